#version 450 core
// Exit radiance of each vertex, albedo left out: the dot product of its transfer vector with the light
// (Sloan et al. 2002, eq. 8). Runs when the light changes, not in every frame.
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer TransferVectors { float transfer[]; };  // vertex-major
layout(std430, binding = 1) writeonly buffer VertexRadiance { float radiance[]; };  // RGB, RGB, ...
layout(std140, binding = 0) uniform Light { vec4 light[100]; };                     // RGB and padding

layout(location = 0) uniform uint vertex_count;       // of the bound range
layout(location = 1) uniform uint coefficient_count;  // order², at most 100

void main() {
  uint vertex = gl_GlobalInvocationID.x;
  if (vertex >= vertex_count) return;
  uint first = vertex * coefficient_count;
  vec3 sum = vec3(0.0);
  for (uint i = 0u; i < coefficient_count; ++i) sum += transfer[first + i] * light[i].rgb;
  radiance[3u * vertex] = sum.r;
  radiance[3u * vertex + 1u] = sum.g;
  radiance[3u * vertex + 2u] = sum.b;
}
