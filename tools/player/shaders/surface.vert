#version 450 core
layout(location = 0) in vec3 position;  // from the centre of the bounding sphere
layout(location = 1) in vec3 radiance;  // written by radiance.comp

layout(location = 0) uniform mat4 clip_from_object;

out vec3 exit_radiance;

void main() {
  exit_radiance = radiance;
  gl_Position = clip_from_object * vec4(position, 1.0);
}
