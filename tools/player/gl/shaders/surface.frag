in vec3 exit_radiance;

layout(location = 0) out vec4 linear;

void main() {
  linear = vec4(exit_radiance, 1.0);
}
