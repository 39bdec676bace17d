// Projection of a cube map into spherical harmonics, second half: the sum of all rows, in order.
layout(local_size_x = 64) in;

layout(std430, binding = 2) writeonly buffer Light { vec4 light[100]; };
layout(std430, binding = 3) readonly buffer RowSums { vec4 row_sums[]; };

layout(location = 0) uniform uint coefficient_count;
layout(location = 1) uniform uint row_count;

void main() {
  uint coefficient = gl_GlobalInvocationID.x;
  if (coefficient >= coefficient_count) return;
  vec4 sum = vec4(0.0);
  for (uint row = 0u; row < row_count; ++row) sum += row_sums[row * coefficient_count + coefficient];
  light[coefficient] = sum;
}
