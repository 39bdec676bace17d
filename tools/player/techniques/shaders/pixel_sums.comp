// Light change, transfer by sums that rows share: the sums of a level, of entries of lower ones. A sum an item.
layout(local_size_x = 64) in;

layout(std430, binding = 1) buffer Table { float table[]; };          // entries × RGB
layout(std430, binding = 3) readonly buffer Sums { uvec2 parts[]; };  // of all levels

layout(location = 0) uniform uint first_entry;
layout(location = 1) uniform uint sum_count;
layout(location = 2) uniform uint first_sum;

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= sum_count) return;
  uvec2 at = 3u * parts[first_sum + i];
  for (uint c = 0u; c < 3u; ++c) table[3u * (first_entry + i) + c] = table[at.x + c] + table[at.y + c];
}
