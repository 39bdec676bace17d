// What texels around each receiver send to it: its kernel of SIDE × SIDE × RGB times what enters there. After table.glsl.
layout(local_size_x = 64) in;

layout(std430, binding = 2) readonly buffer Receivers { uint receivers[]; };  // texels
layout(std430, binding = 3) readonly buffer Places { uint places[]; };        // of texels: row · side + column
layout(std430, binding = 4) writeonly buffer Near { vec4 near[]; };           // a receiver
layout(binding = 0) uniform sampler2D picture;  // what enters, with a margin of SIDE / 2, so that no window leaves it

layout(location = 0) uniform uint first;  // of the bound kernels
layout(location = 1) uniform uint count;
layout(location = 2) uniform uint side;

void main() {
  uint row = gl_GlobalInvocationID.x;
  if (row >= count) return;
  uint receiver = first + row, place = places[receivers[receiver]];
  ivec2 corner = ivec2(place % side, place / side);
  vec3 sum = vec3(0.0);
  uint value = 0u;
  for (int y = 0; y < SIDE; ++y)
    for (int x = 0; x < SIDE; ++x, value += 3u)
      sum += vec3(tableValue(row, value), tableValue(row, value + 1u), tableValue(row, value + 2u)) *
             texelFetch(picture, corner + ivec2(x, y), 0).rgb;
  near[receiver] = vec4(sum, 0.0);
}
