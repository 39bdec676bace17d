// What one punctual light sends into each texel of a translucent object: transport/texel_irradiance.cpp, with the object's shadow from what
// the light sees of it instead of rays. Lengths are from the mesh's origin.
layout(local_size_x = 64) in;

const uint kNone = 0xFFFFFFFFu;
const int kPoint = 0, kSpot = 1;  // transport::PlacedPunctualLight::Type
const int kPlaces = 16, kMostSteps = 4;
const float kCorner = 0.499;

struct Texel {
  uint triangle;
  float u, v;
};
struct Triangle {
  uint corners[3];
  uint neighbours[3];  // triangle · 4 + corner
  float across[2], down[2];
};

layout(std430, binding = 0) buffer Entering { float entering[]; };  // RGB a texel
layout(std430, binding = 1) readonly buffer Texels { Texel texels[]; };
layout(std430, binding = 2) readonly buffer Triangles { Triangle triangles[]; };
layout(std430, binding = 3) readonly buffer Positions { float positions[]; };
layout(std430, binding = 4) readonly buffer Normals { float normals[]; };
layout(binding = 0) uniform sampler2DArray depths;  // a view each; 0: nothing
layout(binding = 1) uniform sampler2D slide;        // rows from the top

layout(location = 0) uniform uint count;
layout(location = 1) uniform int type;
layout(location = 2) uniform vec3 light_position;
layout(location = 3) uniform vec3 intensity;
layout(location = 4) uniform mat3 axes;      // to the right, up, back
layout(location = 5) uniform vec2 cone;      // 1 − cosine of inner and outer half angle
layout(location = 6) uniform vec2 half_size;  // of the slide at a distance of 1
layout(location = 7) uniform float normal_reflectance;
layout(location = 8) uniform float offset;
layout(location = 9) uniform int view_count;
layout(location = 10) uniform float view_tangent;  // of half a view's angle
layout(location = 11) uniform mat3 views[6];        // to the right, up, forward

vec3 vectorOf(uint vertex, bool normal) {
  return normal ? vec3(normals[3u * vertex], normals[3u * vertex + 1u], normals[3u * vertex + 2u])
                : vec3(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
}

// A corner by its distance from the edge from → from + along, and how far along it is, in lengths of the edge.
vec2 placed(vec3 corner, vec3 from, vec3 along) {
  vec3 way = corner - from;
  float share = dot(way, along) / dot(along, along);
  return vec2(length(way - share * along), share);
}

void walk(inout uint triangle, inout vec3 weights) {
  for (int step = 0; step < kMostSteps; ++step) {
    uint k = weights.x <= weights.y ? (weights.x <= weights.z ? 0u : 2u) : (weights.y <= weights.z ? 1u : 2u);
    if (weights[k] >= 0.0) return;
    uint next = triangles[triangle].neighbours[k];
    if (next == kNone) return;
    uint next_triangle = next / 4u, corner = next % 4u;
    vec3 from = vectorOf(triangles[triangle].corners[(k + 1u) % 3u], false);
    vec3 along = vectorOf(triangles[triangle].corners[(k + 2u) % 3u], false) - from;
    vec2 here = placed(vectorOf(triangles[triangle].corners[k], false), from, along);
    vec2 there = placed(vectorOf(triangles[next_triangle].corners[corner], false), from, along);
    if (!(dot(along, along) > 0.0) || !(there.x > 0.0)) return;
    float beyond = -weights[k] * here.x / there.x;
    float second = weights[(k + 2u) % 3u] + weights[k] * here.y - beyond * there.y;
    vec3 moved;
    moved[corner] = beyond;
    moved[(corner + 1u) % 3u] = second;
    moved[(corner + 2u) % 3u] = 1.0 - beyond - second;
    triangle = next_triangle;
    weights = moved;
  }
}

vec3 intensityTowards(vec3 direction) {
  if (type == kPoint) return intensity;
  if (type == kSpot) {
    vec3 away = direction + axes[2];
    float share = clamp((cone.y - dot(away, away) / 2.0) / (cone.y - cone.x), 0.0, 1.0);
    return intensity * (share * share);
  }
  vec3 local = direction * axes;
  if (!(local.z < 0.0)) return vec3(0.0);
  vec2 size = vec2(textureSize(slide, 0));
  vec2 place = (vec2(local.x, -local.y) / (-local.z * half_size) + 1.0) / 2.0 * size;
  if (any(lessThan(place, vec2(0.0))) || any(greaterThanEqual(place, size))) return vec3(0.0);
  return intensity * texelFetch(slide, ivec2(place), 0).rgb;
}

// Whether the light sees something nearer. What it sees in the middle of its texel is held against where the tangent plane is there, so
// that a slanting surface is not in its own shadow.
bool occluded(vec3 origin, vec3 normal) {
  vec3 way = origin - light_position;
  int view = 0;
  for (int i = 1; i < view_count; ++i)
    if (dot(way, views[i][2]) > dot(way, views[view][2])) view = i;
  vec3 local = way * views[view];
  if (!(local.z > 0.0)) return false;
  float side = float(textureSize(depths, 0).x);
  vec2 texel = floor((local.xy / (local.z * view_tangent) + 1.0) / 2.0 * side);
  if (any(lessThan(texel, vec2(0.0))) || any(greaterThanEqual(texel, vec2(side)))) return false;
  float seen = texelFetch(depths, ivec3(texel, view), 0).r;
  if (seen == 0.0) return false;
  vec2 middle = ((texel + 0.5) / side * 2.0 - 1.0) * view_tangent;
  vec3 through = views[view] * vec3(middle, 1.0);
  const float kSteepest = 8.0;  // tangent of the slant that is followed
  float texel_size = 2.0 * view_tangent * local.z / side, facing = dot(normal, through), expected = local.z;
  if (facing < 0.0) expected = dot(normal, way) / facing;
  expected = clamp(expected, local.z - kSteepest * texel_size, local.z + kSteepest * texel_size);
  return seen < expected - 0.25 * texel_size;
}

// What enters at a place, and what would fall on it if it faced the light.
vec3 lightAt(Texel texel, vec2 place, out vec3 facing) {
  uint triangle = texel.triangle;
  float u = texel.u + place.x * triangles[triangle].across[0] + place.y * triangles[triangle].down[0];
  float v = texel.v + place.x * triangles[triangle].across[1] + place.y * triangles[triangle].down[1];
  vec3 weights = vec3(1.0 - u - v, u, v);
  walk(triangle, weights);
  weights = max(weights, 0.0);
  weights /= weights.x + weights.y + weights.z;
  vec3 position = vec3(0.0), normal = vec3(0.0), corners[3], corner_normals[3];
  for (int k = 0; k < 3; ++k) {
    corners[k] = vectorOf(triangles[triangle].corners[k], false);
    corner_normals[k] = vectorOf(triangles[triangle].corners[k], true);
    position += weights[k] * corners[k];
    normal += weights[k] * corner_normals[k];
  }
  float size = length(normal);
  normal = size > 1e-6 ? normal / size : normalize(cross(corners[1] - corners[0], corners[2] - corners[0]));
  vec3 origin = position + offset * normal;
  for (int k = 0; k < 3; ++k)
    origin -= weights[k] * min(0.0, dot(position - corners[k], corner_normals[k])) * corner_normals[k];

  vec3 way = light_position - origin;
  float distance = length(way), cosine = dot(normal, way) / distance;
  facing = distance > 0.0 ? intensityTowards(-way / distance) / (distance * distance) : vec3(0.0);
  if (!(cosine > 0.0)) return vec3(0.0);  // its shadow is no edge
  if (facing == vec3(0.0) || occluded(origin, normal)) {
    facing = vec3(0.0);
    return facing;
  }
  float transmittance = (1.0 - normal_reflectance) * (1.0 - pow(1.0 - min(cosine, 1.0), 5.0));
  return facing * (cosine * transmittance);
}

void main() {
  uint t = gl_GlobalInvocationID.x;
  if (t >= count) return;
  Texel texel = texels[t];
  vec3 least = vec3(0.0), most = vec3(0.0), sum = vec3(0.0), facing;
  for (int i = 0; i < 4; ++i) {
    sum += lightAt(texel, kCorner * vec2((i & 1) * 2 - 1, (i >> 1) * 2 - 1), facing);
    least = i == 0 ? facing : min(least, facing);
    most = max(most, facing);
  }
  if (all(lessThanEqual(most - least, 0.1 * most))) {
    sum /= 4.0;
  } else {
    sum = vec3(0.0);
    for (int i = 0; i < kPlaces; ++i)
      sum += lightAt(texel, vec2((float(i) + 0.5) / float(kPlaces),
                                 (float(bitfieldReverse(uint(i)) >> 28) + 0.5) / float(kPlaces)) - 0.5,
                     facing);
    sum /= float(kPlaces);
  }
  for (uint c = 0u; c < 3u; ++c) entering[3u * t + c] += sum[c];
}
