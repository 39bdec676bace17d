// Light change, transfer by sums that rows share: the sums of a level, of entries of lower ones. A sum an item.
layout(local_size_x = 64) in;

layout(std430, binding = 1) writeonly buffer Table { vec4 table[]; };  // entries: RGB, 0
layout(std430, binding = 3) readonly buffer Sums { uvec2 parts[]; };  // of all levels

layout(binding = 0) uniform samplerBuffer entries;

layout(location = 0) uniform uint first_entry;
layout(location = 1) uniform uint sum_count;
layout(location = 2) uniform uint first_sum;

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= sum_count) return;
  ivec2 at = ivec2(parts[first_sum + i]);
  table[first_entry + i] = texelFetch(entries, at.x) + texelFetch(entries, at.y);
}
