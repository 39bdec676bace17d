// Of what enters texels, what comes to each knot: power for the throughput factors, and what blend weights give it without them.
layout(local_size_x = 64) in;

struct Gift {
  uint texel, power_red, green_blue;  // halves: power, and blend in three colours
};

layout(std430, binding = 0) readonly buffer Ends { uint ends[]; };  // of each knot's gifts
layout(std430, binding = 1) readonly buffer Gifts { Gift gifts[]; };
layout(std430, binding = 2) readonly buffer Entering { float entering[]; };  // RGB a texel
layout(std430, binding = 3) writeonly buffer Powers { vec4 powers[]; };
layout(std430, binding = 4) writeonly buffer Given { vec4 given[]; };

layout(location = 0) uniform uint first;
layout(location = 1) uniform uint count;

void main() {
  if (gl_GlobalInvocationID.x >= count) return;
  uint knot = first + gl_GlobalInvocationID.x;
  vec3 power = vec3(0.0), blended = vec3(0.0);
  for (uint g = knot == 0u ? 0u : ends[knot - 1u]; g < ends[knot]; ++g) {
    Gift gift = gifts[g];
    vec3 light = vec3(entering[3u * gift.texel], entering[3u * gift.texel + 1u], entering[3u * gift.texel + 2u]);
    vec2 power_red = unpackHalf2x16(gift.power_red);
    power += power_red.x * light;
    blended += vec3(power_red.y, unpackHalf2x16(gift.green_blue)) * light;
  }
  powers[knot] = vec4(power, 0.0);
  given[knot] = vec4(blended, 0.0);
}
