// The sum of two lights.
layout(local_size_x = 64) in;

layout(std430, binding = 2) writeonly buffer Sum { vec4 sum[100]; };
layout(std140, binding = 0) uniform Light { vec4 light[100]; };
layout(std140, binding = 1) uniform SecondLight { vec4 second_light[100]; };

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i < 100u) sum[i] = light[i] + second_light[i];
}
