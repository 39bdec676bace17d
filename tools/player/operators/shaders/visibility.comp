// Operator × visibility for each vertex. One work item a block of the result's coefficients, so that visibility is
// decoded once for all of them. After table.glsl, whose columns are those of the operator.
layout(local_size_x = 64) in;

layout(std430, binding = 2) writeonly buffer Transferred { float transferred[]; };  // n × ROW_COEFFICIENTS × RGB
layout(std430, binding = 3) readonly buffer Operator { vec4 operator_cells[]; };

layout(location = 0) uniform uint row_count;  // of the bound range

void main() {
  const uint block_count = (ROW_COEFFICIENTS + BLOCK - 1u) / BLOCK;
  uint item = gl_GlobalInvocationID.x;
  if (item >= row_count * block_count) return;
  uint row = item / block_count;
  uint first = (item % block_count) * BLOCK;
  vec3 sums[BLOCK];
  for (uint b = 0u; b < BLOCK; ++b) sums[b] = vec3(0.0);
  for (uint k = 0u; k < TABLE_COLUMNS; ++k) {
    float visibility = tableValue(row, k);
    // Past the last coefficient the last one is computed again, and not written.
    for (uint b = 0u; b < BLOCK; ++b)
      sums[b] += visibility * operator_cells[min(first + b, ROW_COEFFICIENTS - 1u) * TABLE_COLUMNS + k].rgb;
  }
  for (uint b = 0u; b < BLOCK; ++b) {
    if (first + b >= ROW_COEFFICIENTS) return;
    uint at = 3u * (row * ROW_COEFFICIENTS + first + b);
    transferred[at] = sums[b].r;
    transferred[at + 1u] = sums[b].g;
    transferred[at + 2u] = sums[b].b;
  }
}
