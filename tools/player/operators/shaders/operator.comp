// The operator that turns visibility into transferred radiance under one light (transport/triple_product.h):
// operator[i][k] = Σ_j Γ_ijk light[j]. The entries of Γ come sorted by i, k and j.
layout(local_size_x = 64) in;

struct Entry {
  uint j;
  float value;
};
layout(std430, binding = 2) writeonly buffer Operator { vec4 operator_cells[]; };  // RGB and padding
layout(std430, binding = 3) readonly buffer Entries { Entry entries[]; };
layout(std430, binding = 4) readonly buffer CellEnds { uint cell_ends[]; };  // where the entries of a cell end
layout(std140, binding = 0) uniform Light { vec4 light[100]; };

layout(location = 0) uniform uint cell_count;

void main() {
  uint cell = gl_GlobalInvocationID.x;
  if (cell >= cell_count) return;
  vec3 sum = vec3(0.0);
  uint begin = cell == 0u ? 0u : cell_ends[cell - 1u];
  for (uint entry = begin; entry < cell_ends[cell]; ++entry)
    sum += entries[entry].value * light[entries[entry].j].rgb;
  operator_cells[cell] = vec4(sum, 0.0);
}
