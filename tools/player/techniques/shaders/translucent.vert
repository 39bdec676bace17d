layout(location = 0) in vec3 position;  // from the mesh's origin
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 stain;
layout(location = 3) in vec2 texcoord;

layout(location = 0) uniform mat4 clip_from_position;

out vec3 surface_position, surface_normal, surface_stain;
out vec2 surface_texcoord;

void main() {
  surface_position = position;
  surface_normal = normal;
  surface_stain = stain;
  surface_texcoord = texcoord;
  gl_Position = clip_from_position * vec4(position, 1.0);
}
