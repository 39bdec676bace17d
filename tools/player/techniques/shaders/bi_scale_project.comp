// Light change: products of each vertex's transferred radiance with the bases of its radiance transfer texture, four
// components at once. Definitions: ORDER² coefficients of the texture, OUTPUT_ORDER² of transferred radiance.
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Transferred { float transferred[]; };  // n × OUTPUT_ORDER² × RGB
layout(std430, binding = 1) readonly buffer Basis { vec4 basis[]; };               // groups × ORDER² × RGB
layout(std430, binding = 2) readonly buffer Albedo { float albedo[]; };            // RGB, RGB, ...
layout(std430, binding = 3) writeonly buffer Projected { vec4 projected[]; };      // n × most_groups × RGB

layout(location = 0) uniform uint vertex_end;  // in the bound range
layout(location = 1) uniform uint vertex_first;
layout(location = 2) uniform uint groups;
layout(location = 3) uniform uint most_groups;
layout(location = 4) uniform uint coefficients;
layout(location = 5) uniform uint output_coefficients;

void main() {
  uint vertex = vertex_first + gl_GlobalInvocationID.x / groups;
  uint group = gl_GlobalInvocationID.x % groups;
  if (vertex >= vertex_end) return;
  vec4 sum[3] = vec4[3](vec4(0.0), vec4(0.0), vec4(0.0));
  for (uint i = 0u; i < coefficients; ++i)
    for (uint c = 0u; c < 3u; ++c)
      sum[c] += basis[(group * coefficients + i) * 3u + c] * transferred[(vertex * output_coefficients + i) * 3u + c];
  for (uint c = 0u; c < 3u; ++c)
    projected[(vertex * most_groups + group) * 3u + c] = albedo[3u * vertex + c] * sum[c];
}
