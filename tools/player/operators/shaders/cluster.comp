// Transferred radiance of each vertex from that of its cluster's matrices (Sloan et al. 2003): mean + Σ_k weight_k ·
// basis_k. One work item a coefficient of the result. After table.glsl, which holds the weights.
layout(local_size_x = 64) in;

layout(std430, binding = 2) writeonly buffer Transferred { float transferred[]; };  // n × ROW_COEFFICIENTS × RGB
layout(std430, binding = 3) readonly buffer Projected { float projected[]; };  // of each matrix of each cluster, likewise
layout(std430, binding = 4) readonly buffer Clusters { uint clusters[]; };     // of each vertex

layout(location = 0) uniform uint row_count;  // of the bound range

vec3 projectedAt(uint matrix, uint coefficient) {
  uint at = 3u * (matrix * ROW_COEFFICIENTS + coefficient);
  return vec3(projected[at], projected[at + 1u], projected[at + 2u]);
}

void main() {
  uint item = gl_GlobalInvocationID.x;
  if (item >= row_count * ROW_COEFFICIENTS) return;
  uint row = item / ROW_COEFFICIENTS;
  uint coefficient = item % ROW_COEFFICIENTS;
  uint mean = clusters[row] * (1u + TABLE_COLUMNS);
  vec3 sum = projectedAt(mean, coefficient);
  for (uint k = 0u; k < TABLE_COLUMNS; ++k) sum += tableValue(row, k) * projectedAt(mean + 1u + k, coefficient);
  transferred[3u * item] = sum.r;
  transferred[3u * item + 1u] = sum.g;
  transferred[3u * item + 2u] = sum.b;
}
