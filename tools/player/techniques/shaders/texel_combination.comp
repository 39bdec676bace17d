// Radiosity below the surface at each receiver: what comes from near by and, interpolated, what came to its three knots. After table.glsl,
// whose rows are the weights of the second and third knot of each texel.
layout(local_size_x = 64) in;

layout(std430, binding = 2) readonly buffer Receivers { uint receivers[]; };  // texels
layout(std430, binding = 3) readonly buffer Places { uint places[]; };        // of texels: row · side + column
layout(std430, binding = 4) readonly buffer Knots { uint knots[]; };          // 3 a texel
layout(std430, binding = 5) readonly buffer Near { vec4 near[]; };            // a receiver
layout(std430, binding = 6) readonly buffer AtKnots { vec4 at_knots[]; };
layout(rgba32f, binding = 0) writeonly uniform image2D radiosity;  // alpha 1 where there is any

layout(location = 0) uniform uint first;
layout(location = 1) uniform uint count;
layout(location = 2) uniform uint side;

void main() {
  if (gl_GlobalInvocationID.x >= count) return;
  uint receiver = first + gl_GlobalInvocationID.x, texel = receivers[receiver], place = places[texel];
  float second = tableValue(texel, 0u), third = tableValue(texel, 1u);
  vec3 sum = near[receiver].rgb + (1.0 - second - third) * at_knots[knots[3u * texel]].rgb +
             second * at_knots[knots[3u * texel + 1u]].rgb + third * at_knots[knots[3u * texel + 2u]].rgb;
  imageStore(radiosity, ivec2(place % side, place / side), vec4(sum, 1.0));
}
