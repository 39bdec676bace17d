// What enters each texel of a translucent object: radiance of its three vertices by transfer vectors, interpolated, on top of what other
// lights send in. After table.glsl, whose rows are the weights of the second and third vertex of each texel.
layout(local_size_x = 64) in;

const float kPi = 3.14159265358979;

layout(std430, binding = 2) readonly buffer Vertices { uint vertices[]; };  // 3 a texel
layout(std430, binding = 3) readonly buffer Radiance { float radiance[]; };  // RGB a vertex, of a white surface
layout(std430, binding = 4) readonly buffer Places { uint places[]; };      // row · side + column
layout(std430, binding = 5) readonly buffer Others { float others[]; };     // RGB a texel
layout(std430, binding = 6) writeonly buffer Entering { float entering[]; };  // likewise
layout(rgba32f, binding = 0) writeonly uniform image2D picture;  // the same in the atlas, MARGIN around it

layout(location = 0) uniform uint first;
layout(location = 1) uniform uint count;
layout(location = 2) uniform uint side;
layout(location = 3) uniform bool has_others;

vec3 radianceOf(uint vertex) {
  return vec3(radiance[3u * vertex], radiance[3u * vertex + 1u], radiance[3u * vertex + 2u]);
}

void main() {
  uint row = gl_GlobalInvocationID.x;  // of the bound table
  if (row >= count) return;
  uint texel = first + row;
  float second = tableValue(row, 0u), third = tableValue(row, 1u);
  vec3 sum = (1.0 - second - third) * radianceOf(vertices[3u * texel]) +
             second * radianceOf(vertices[3u * texel + 1u]) + third * radianceOf(vertices[3u * texel + 2u]);
  sum = max(kPi * sum, 0.0);  // where spherical harmonics ring below 0, nothing enters
  if (has_others) sum += vec3(others[3u * texel], others[3u * texel + 1u], others[3u * texel + 2u]);
  entering[3u * texel] = sum.r;
  entering[3u * texel + 1u] = sum.g;
  entering[3u * texel + 2u] = sum.b;
  uint place = places[texel];
  imageStore(picture, ivec2(place % side, place / side) + MARGIN, vec4(sum, 0.0));
}
