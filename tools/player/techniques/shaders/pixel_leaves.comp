// Light change, first step of transfer by sums that rows share: a texel's light times a code. A leaf an item; entry 0 of the table is 0.
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Light { float light[]; };     // texels × RGB: radiance × solid angle ÷ subsamples²
layout(std430, binding = 1) writeonly buffer Table { vec4 table[]; };  // entries: RGB, 0
layout(std430, binding = 3) readonly buffer Leaves { uint leaves[]; };    // column, and code from bit 16 on

layout(location = 0) uniform uint leaf_count;

void main() {
  uint leaf = gl_GlobalInvocationID.x;
  if (leaf >= leaf_count) return;
  uint column = 3u * (leaves[leaf] & 0xffffu);
  float code = float(leaves[leaf] >> 16);
  table[leaf + 1u] = vec4(code * vec3(light[column], light[column + 1u], light[column + 2u]), 0.0);
}
