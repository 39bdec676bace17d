// Exit radiance of each vertex: its albedo times the dot product of its transfer vector with the light (Sloan et al.
// 2002, eq. 8), on top of what another light gave. Runs when the light changes, not in every frame. After table.glsl.
// Definitions: CHANNELS (1 or 3), COEFFICIENTS (order²), VERTEX_COLORS and ADDED where there are any.
layout(local_size_x = 64) in;

layout(std430, binding = 2) writeonly buffer ExitRadiance { float radiance[]; };  // RGB, RGB, ...
layout(std430, binding = 3) readonly buffer VertexColors { float colors[]; };     // likewise
layout(std430, binding = 4) readonly buffer Added { float added[]; };             // likewise
layout(std140, binding = 0) uniform Light { vec4 light[100]; };                   // RGB and padding

layout(location = 0) uniform uint vertex_count;  // of the bound range
layout(location = 1) uniform vec3 base_color;

void main() {
  uint vertex = gl_GlobalInvocationID.x;
  if (vertex >= vertex_count) return;
  vec3 sum = vec3(0.0);
  for (uint i = 0u; i < COEFFICIENTS; ++i) {
#if CHANNELS == 3
    vec3 transfer = vec3(tableValue(vertex, i), tableValue(vertex, COEFFICIENTS + i),
                         tableValue(vertex, 2u * COEFFICIENTS + i));
#else
    float transfer = tableValue(vertex, i);
#endif
    sum += transfer * light[i].rgb;
  }
  sum *= base_color;
  uint first = 3u * vertex;
#ifdef VERTEX_COLORS
  sum *= vec3(colors[first], colors[first + 1u], colors[first + 2u]);
#endif
#ifdef ADDED
  sum += vec3(added[first], added[first + 1u], added[first + 2u]);
#endif
  radiance[first] = sum.r;
  radiance[first + 1u] = sum.g;
  radiance[first + 2u] = sum.b;
}
