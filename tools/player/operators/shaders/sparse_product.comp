// y = M x, or y + M x, of three colours: the entries of a sparse matrix by its rows. LANES work items share a row and add up in a fixed
// order. After table.glsl, whose rows are entries of one value or of three.
layout(local_size_x = 64) in;

layout(std430, binding = 2) readonly buffer Ends { uint ends[]; };
layout(std430, binding = 3) readonly buffer Columns { uint columns[]; };  // of the bound range, as the table's rows
layout(std430, binding = 4) readonly buffer Factors { vec4 x[]; };
layout(std430, binding = 5) buffer Products { vec4 y[]; };

layout(location = 0) uniform uint first_row;
layout(location = 1) uniform uint end_row;
layout(location = 2) uniform uint first_entry;  // of the bound range
layout(location = 3) uniform bool adds;

#if LANES > 1
shared vec3 partial[64];
#endif

void main() {
  uint lane = gl_LocalInvocationID.x % LANES;
  uint row = first_row + gl_GlobalInvocationID.x / LANES;
  vec3 sum = vec3(0.0);
  if (row < end_row) {
    uint begin = (row == 0u ? 0u : ends[row - 1u]) - first_entry, end = ends[row] - first_entry;
    for (uint e = begin + lane; e < end; e += LANES) {
#if TABLE_COLUMNS == 3
      vec3 value = vec3(tableValue(e, 0u), tableValue(e, 1u), tableValue(e, 2u));
#else
      float value = tableValue(e, 0u);
#endif
      sum += value * x[columns[e]].rgb;
    }
  }
#if LANES > 1
  uint item = gl_LocalInvocationID.x;
  partial[item] = sum;
  barrier();
  for (uint step = LANES / 2u; step > 0u; step /= 2u) {
    if (lane < step) partial[item] += partial[item + step];
    barrier();
  }
  sum = partial[item];
#endif
  if (lane == 0u && row < end_row) y[row] = vec4(adds ? y[row].rgb + sum : sum, 0.0);
}
