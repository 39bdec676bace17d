// Operator × visibility for each vertex. One work item a coefficient of the result. After table.glsl, whose columns are
// those of the operator.
layout(local_size_x = 64) in;

layout(std430, binding = 2) writeonly buffer Transferred { float transferred[]; };  // n × ROW_COEFFICIENTS × RGB
layout(std430, binding = 3) readonly buffer Operator { vec4 operator_cells[]; };

layout(location = 0) uniform uint row_count;  // of the bound range

void main() {
  uint item = gl_GlobalInvocationID.x;
  if (item >= row_count * ROW_COEFFICIENTS) return;
  uint row = item / ROW_COEFFICIENTS;
  uint first = (item % ROW_COEFFICIENTS) * TABLE_COLUMNS;
  vec3 sum = vec3(0.0);
  for (uint k = 0u; k < TABLE_COLUMNS; ++k) sum += tableValue(row, k) * operator_cells[first + k].rgb;
  transferred[3u * item] = sum.r;
  transferred[3u * item + 1u] = sum.g;
  transferred[3u * item + 2u] = sum.b;
}
