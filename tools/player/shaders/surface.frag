#version 450 core
in vec3 exit_radiance;

layout(location = 1) uniform vec3 base_color;

layout(location = 0) out vec4 linear;

void main() {
  linear = vec4(base_color * exit_radiance, 1.0);
}
