// Radiance of each vertex of a receiver in the light around an object: what the neighborhood transfer changes, interpolated between eight points of
// its grid, on top of the light's own; then the clamped cosine around the normal (transport::VolumeShading).
layout(local_size_x = 64) in;

const int kReceived = 18;  // coefficients: bands 0, 1, 2 and 4

layout(std430, binding = 0) readonly buffer Positions { float positions[]; };  // XYZ from the receiver's middle
layout(std430, binding = 1) readonly buffer Normals { float normals[]; };
layout(std430, binding = 2) writeonly buffer Radiance { float radiance[]; };
layout(std430, binding = 3) readonly buffer Changes { float changes[]; };  // points × kReceived × RGB
layout(std430, binding = 4) readonly buffer Axes { float axes[]; };        // x, then y, then z, from the object's middle
layout(std140, binding = 0) uniform Light { vec4 light[100]; };

layout(location = 0) uniform uint vertex_count;
layout(location = 1) uniform mat3 object_from_world;
layout(location = 2) uniform vec3 middle;  // of the receiver, in the world, from the object's middle
layout(location = 3) uniform float radius;
layout(location = 4) uniform vec3 albedo;
layout(location = 5) uniform uvec3 counts;
layout(location = 6) uniform uint light_coefficients;

// A_l y_lm(n) / π.
void cosineLobe(vec3 n, out float lobe[kReceived]) {
  float x = n.x, y = n.y, z = n.z, x2 = x * x, y2 = y * y, z2 = z * z;
  lobe[0] = 0.28209479177387814;
  const float l1 = 0.4886025119029199 * 2.0 / 3.0;
  lobe[1] = l1 * y;
  lobe[2] = l1 * z;
  lobe[3] = l1 * x;
  const float l2 = 1.0925484305920792 / 4.0;
  lobe[4] = l2 * x * y;
  lobe[5] = l2 * y * z;
  lobe[6] = 0.31539156525252005 / 4.0 * (3.0 * z2 - 1.0);
  lobe[7] = l2 * x * z;
  lobe[8] = l2 * 0.5 * (x2 - y2);
  const float l4 = -1.0 / 24.0;
  lobe[9] = l4 * 2.5033429417967046 * x * y * (x2 - y2);
  lobe[10] = l4 * 1.7701307697799304 * y * z * (3.0 * x2 - y2);
  lobe[11] = l4 * 0.9461746957575601 * x * y * (7.0 * z2 - 1.0);
  lobe[12] = l4 * 0.6690465435572892 * y * z * (7.0 * z2 - 3.0);
  lobe[13] = l4 * 0.10578554691520431 * ((35.0 * z2 - 30.0) * z2 + 3.0);
  lobe[14] = l4 * 0.6690465435572892 * x * z * (7.0 * z2 - 3.0);
  lobe[15] = l4 * 0.47308734787878004 * (x2 - y2) * (7.0 * z2 - 1.0);
  lobe[16] = l4 * 1.7701307697799304 * x * z * (x2 - 3.0 * y2);
  lobe[17] = l4 * 0.6258357354491761 * (x2 * (x2 - 3.0 * y2) - y2 * (3.0 * x2 - y2));
}

// Interval of an axis that begins at `first` in the list, and how far along it.
void placeOn(uint first, uint count, float at, out uint interval, out float along) {
  uint low = 0u, high = count - 1u;
  while (high - low > 1u) {
    uint between = (low + high) / 2u;
    if (axes[first + between] <= at) low = between; else high = between;
  }
  interval = low;
  along = clamp((at - axes[first + low]) / (axes[first + high] - axes[first + low]), 0.0, 1.0);
}

void main() {
  uint vertex = gl_GlobalInvocationID.x;
  if (vertex >= vertex_count) return;
  vec3 position = vec3(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
  vec3 normal = object_from_world * vec3(normals[3u * vertex], normals[3u * vertex + 1u], normals[3u * vertex + 2u]);
  vec3 at = object_from_world * (middle + radius * position);

  float lobe[kReceived];
  cosineLobe(normal, lobe);
  vec3 sum = vec3(0.0);
  for (int i = 0; i < kReceived; ++i) {
    uint coefficient = uint(i < 9 ? i : i + 7);
    if (coefficient < light_coefficients) sum += lobe[i] * light[coefficient].rgb;
  }

  uint y_first = counts.x, z_first = counts.x + counts.y;
  bool inside = at.x >= axes[0] && at.x <= axes[y_first - 1u] && at.y <= axes[z_first - 1u] && at.z >= axes[z_first] &&
                at.z <= axes[z_first + counts.z - 1u];
  if (inside) {
    uvec3 interval;
    vec3 along;
    placeOn(0u, counts.x, at.x, interval.x, along.x);
    placeOn(y_first, counts.y, at.y, interval.y, along.y);
    placeOn(z_first, counts.z, at.z, interval.z, along.z);
    for (uint corner = 0u; corner < 8u; ++corner) {
      uvec3 upper = uvec3(corner & 1u, corner >> 1u & 1u, corner >> 2u);
      vec3 weights = mix(1.0 - along, along, vec3(upper));
      uvec3 cell = interval + upper;
      uint first = 3u * uint(kReceived) * (cell.x + counts.x * (cell.y + counts.y * cell.z));
      vec3 change = vec3(0.0);
      for (uint i = 0u; i < uint(kReceived); ++i)
        change += lobe[i] * vec3(changes[first + 3u * i], changes[first + 3u * i + 1u], changes[first + 3u * i + 2u]);
      sum += weights.x * weights.y * weights.z * change;
    }
  }
  sum *= albedo;
  radiance[3u * vertex] = sum.r;
  radiance[3u * vertex + 1u] = sum.g;
  radiance[3u * vertex + 2u] = sum.b;
}
