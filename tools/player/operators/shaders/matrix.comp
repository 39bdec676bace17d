// Matrix × light for each row of a table of matrices: n × (CHANNELS · ROW_COEFFICIENTS · COEFFICIENTS). The rows are
// vertices, or the matrices of all clusters. One work item a coefficient of the result. After table.glsl.
layout(local_size_x = 64) in;

layout(std430, binding = 2) writeonly buffer Transferred { float transferred[]; };  // n × ROW_COEFFICIENTS × RGB
layout(std140, binding = 0) uniform Light { vec4 light[100]; };

layout(location = 0) uniform uint row_count;  // of the bound range

void main() {
  uint item = gl_GlobalInvocationID.x;
  if (item >= row_count * ROW_COEFFICIENTS) return;
  uint row = item / ROW_COEFFICIENTS;
  uint first = (item % ROW_COEFFICIENTS) * COEFFICIENTS;
  vec3 sum = vec3(0.0);
  for (uint j = 0u; j < COEFFICIENTS; ++j) {
#if CHANNELS == 3
    const uint matrix_size = ROW_COEFFICIENTS * COEFFICIENTS;
    vec3 entry = vec3(tableValue(row, first + j), tableValue(row, matrix_size + first + j),
                      tableValue(row, 2u * matrix_size + first + j));
#else
    float entry = tableValue(row, first + j);
#endif
    sum += entry * light[j].rgb;
  }
  transferred[3u * item] = sum.r;
  transferred[3u * item + 1u] = sum.g;
  transferred[3u * item + 2u] = sum.b;
}
