// Light change: what falls on each cell of the hemispheres over vertices, from a cube map of light. A row of the transfer matrix an item.
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Light { float light[]; };       // texels × RGB: radiance × solid angle ÷ subsamples²
layout(std430, binding = 1) readonly buffer Offsets { uint offsets[]; };    // rows + 1
layout(std430, binding = 2) readonly buffer Entries { uint entries[]; };    // column, and code from bit 16 on
layout(std430, binding = 3) writeonly buffer Incident { float incident[]; };  // rows × RGB

layout(location = 0) uniform uint row_count;
layout(location = 1) uniform uint first_row;

void main() {
  uint row = gl_GlobalInvocationID.x;
  if (row >= row_count) return;
  vec3 sum = vec3(0.0);
  for (uint i = offsets[row]; i < offsets[row + 1u]; ++i) {
    uint column = 3u * (entries[i] & 0xffffu);
    sum += float(entries[i] >> 16) * vec3(light[column], light[column + 1u], light[column + 2u]);
  }
  for (uint c = 0u; c < 3u; ++c) incident[3u * (first_row + row) + c] = sum[c];
}
