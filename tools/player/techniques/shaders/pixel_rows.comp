// Light change, last step of transfer by sums that rows share: what falls on each cell of the hemispheres over vertices. A row an item; a work group's
// rows have as many terms as its longest, the others' last being entry 0, which is 0.
layout(local_size_x = 64) in;

layout(binding = 0) uniform samplerBuffer entries;  // RGB, 0
layout(std430, binding = 2) writeonly buffer Incident { float incident[]; };  // rows × RGB
layout(std430, binding = 3) readonly buffer Begins { uint begins[]; };        // of work groups' terms; one more
layout(std430, binding = 4) readonly buffer Terms { uint terms[]; };          // a group's first ones, its second ones, …
layout(std430, binding = 5) readonly buffer Places { uint places[]; };        // of rows in the matrix; ~0: none

void main() {
  uint end = begins[gl_WorkGroupID.x + 1u];
  vec3 sum = vec3(0.0);
  for (uint t = begins[gl_WorkGroupID.x] + gl_LocalInvocationID.x; t < end; t += 64u) {
    sum += texelFetch(entries, int(terms[t])).rgb;
  }
  uint place = places[gl_GlobalInvocationID.x];
  if (place == ~0u) return;
  for (uint c = 0u; c < 3u; ++c) incident[3u * place + c] = sum[c];
}
