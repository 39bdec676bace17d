layout(location = 0) in vec3 position;  // from the centre of the object's bounding sphere
layout(location = 1) in vec3 radiance;  // albedo included

layout(location = 0) uniform mat4 clip_from_position;

out vec3 exit_radiance;
out vec2 place;

void main() {
  exit_radiance = radiance;
  place = position.xz;
  gl_Position = clip_from_position * vec4(position, 1.0);
}
