// Light change: products of each vertex's transferred radiance with the bases of its patch, four
// components to a group and GROUPS of them at once. Definitions: GROUPS; INCIDENT values: coefficients or cells.
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Transferred { float transferred[]; };  // n × output_coefficients × RGB
layout(std430, binding = 2) readonly buffer Albedo { float albedo[]; };            // RGB, RGB, ...
layout(std430, binding = 3) writeonly buffer Projected { vec4 projected[]; };      // n × most_groups × RGB

layout(std430, binding = 1) readonly buffer Basis { vec4 basis[]; };  // INCIDENT × RGB × GROUPS

#ifdef BLOCKS
layout(std430, binding = 4) readonly buffer Blocks { uint block[]; };  // which row of `transferred` is a vertex's
#endif

layout(location = 0) uniform uint vertex_end;  // in the bound range
layout(location = 1) uniform uint vertex_first;
layout(location = 2) uniform uint first_group;
layout(location = 3) uniform uint most_groups;
layout(location = 4) uniform uint output_coefficients;

void main() {
  uint vertex = vertex_first + gl_GlobalInvocationID.x;
  if (vertex >= vertex_end) return;
#ifdef BLOCKS
  uint row = block[vertex];
#else
  uint row = vertex;
#endif
  vec4 sum[3 * GROUPS];
  for (uint k = 0u; k < 3u * uint(GROUPS); ++k) sum[k] = vec4(0.0);
  for (uint i = 0u; i < INCIDENT; ++i)
    for (uint c = 0u; c < 3u; ++c) {
      float incident = transferred[(row * output_coefficients + i) * 3u + c];
      for (uint g = 0u; g < uint(GROUPS); ++g) sum[3u * g + c] += incident * basis[(i * 3u + c) * uint(GROUPS) + g];
    }
  for (uint g = 0u; g < uint(GROUPS); ++g)
    for (uint c = 0u; c < 3u; ++c)
      projected[(vertex * most_groups + first_group + g) * 3u + c] = albedo[3u * vertex + c] * sum[3u * g + c];
}
