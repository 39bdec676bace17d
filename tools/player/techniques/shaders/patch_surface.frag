// B(q(u), v) · (M L) of a pixel (transport::BiScaleShading). Definitions: GROUPS; VIEWS, a side of the grid of views;
// LEVELS of the pyramid; INDEX if an image says where in the patch a texel is; RELIEF_STEPS and its constants if views are looked
// up along the relief (transport::PatchLookup); CREASES as in patch_surface.vert.
in vec3 surface_position, surface_normal;
in vec4 surface_tangent;
in vec2 surface_texcoord;
in vec4 incident[3 * GROUPS];
#ifdef CREASES
flat in int shown_corner;
in vec2 corner_weights;
#endif

layout(location = 1) uniform vec3 eye;  // where positions are
layout(location = 2) uniform float pixel_angle;
layout(location = 3) uniform float texel_width;  // on the surface
layout(location = 4) uniform int first_group;
layout(location = 5) uniform float alpha;
#ifdef INDEX
layout(location = 6) uniform vec4 index_decoding;  // scale, offset
layout(binding = 1) uniform sampler2D places;
#else
layout(location = 6) uniform vec2 repeats;
#endif
layout(location = 7) uniform ivec4 levels[LEVELS];  // x, y, width and height, in texels of the patch

// A layer a group: blocks of views, side by side as texels are. With relief, where each view has a place of its own, a layer a
// view: the groups of a texel side by side.
layout(binding = 0) uniform sampler2DArray factors;
#ifdef RELIEF_STEPS
layout(binding = 2) uniform sampler2DArray heights;  // a layer a view
layout(binding = 3) uniform sampler2D slopes;        // of views
layout(location = 32) uniform float start_height;
#endif

layout(location = 0) out vec4 linear;

// transport::squareFromHemisphere.
vec2 squareOf(vec3 direction) {
  float z = max(direction.z, 0.0);
  vec2 size = abs(direction.xy);
  float across = length(size);
  if (across == 0.0) return vec2(0.5);
  float whole = sqrt(across * across + z * z);
  float radius = (across / whole) / sqrt(1.0 + z / whole);
  float share = radius * atan(min(size.x, size.y) / max(size.x, size.y)) * 1.2732395447351628;
  vec2 place = size.x > size.y ? vec2(radius, share) : vec2(share, radius);
  return 0.5 + 0.5 * vec2(direction.x < 0.0 ? -place.x : place.x, direction.y < 0.0 ? -place.y : place.y);
}

vec2 placeInPatch() {
#ifdef INDEX
  ivec2 size = textureSize(places, 0);
  ivec2 texel = clamp(ivec2(vec2(surface_texcoord.x, 1.0 - surface_texcoord.y) * vec2(size)), ivec2(0), size - 1);
  return index_decoding.zw + index_decoding.xy * 255.0 * texelFetch(places, texel, 0).rg;
#else
  return fract(surface_texcoord * repeats);
#endif
}

ivec2 texelAt(int level, vec2 place) {
  ivec4 part = levels[level];
  return part.xy + clamp(ivec2(fract(vec2(place.x, 1.0 - place.y)) * vec2(part.zw)), ivec2(0), part.zw - 1);
}

#ifdef RELIEF_STEPS
// Where a view sees what is seen at `place` along the eye's slope; z: whether it does, 0–1.
vec3 seenBy(ivec2 cell, vec2 slope, vec2 place, int level) {
  vec2 shift = slope - texelFetch(slopes, cell, 0).xy;
  shift.y *= float(levels[0].z) / float(levels[0].w);
  vec2 last = place, at = place + start_height * shift;
  for (int step = 0; step < RELIEF_STEPS; ++step) {
    last = at;
    at = place + textureLod(heights, vec3(at.x, 1.0 - at.y, cell.y * VIEWS + cell.x), float(level)).r * shift;
  }
  vec2 off = (at - last) * vec2(levels[level].zw);
  return vec3(at, UNSEEN_RELIEF_WEIGHT + exp(-dot(off, off)));
}
#endif

void main() {
#ifdef CREASES
  // The nearest corner; the first of equals.
  if (shown_corner >= 0) {
    vec3 weights = vec3(corner_weights, 1.0 - corner_weights.x - corner_weights.y);
    int nearest = weights.x >= max(weights.y, weights.z) ? 0 : weights.y >= weights.z ? 1 : 2;
    if (nearest != shown_corner) discard;
  }
#endif
  vec3 n = normalize(surface_normal);
  vec3 t = normalize(surface_tangent.xyz - dot(surface_tangent.xyz, n) * n);
  vec3 b = surface_tangent.w * cross(n, t);
  vec3 offset = eye - surface_position;
  float distance_to_eye = length(offset);
  vec3 to_eye = offset / distance_to_eye;
  vec3 local_eye = vec3(dot(to_eye, t), dot(to_eye, b), dot(to_eye, n));
  float covered = distance_to_eye * pixel_angle / (texel_width * sqrt(max(local_eye.z, 0.01)));
  float level = clamp(covered > 1.0 ? log2(covered) : 0.0, 0.0, float(LEVELS - 1));
  int fine = int(level);
  // transport::rttLevelsAt.
  float blend = clamp((level - float(fine) - 0.35) / 0.3, 0.0, 1.0);
  if (blend >= 1.0) {
    ++fine;
    blend = 0.0;
  }
  vec2 place = placeInPatch();
  vec2 view = clamp(squareOf(local_eye) * float(VIEWS) - 0.5, 0.0, float(VIEWS) - 1.0);
#ifdef RELIEF_STEPS
  ivec2 cell = min(ivec2(view), VIEWS - 2);
  vec2 share = view - vec2(cell);
  vec2 slope = local_eye.xy / max(local_eye.z, LEAST_RELIEF_COSINE);
  vec3 seen[4];
  float total = 0.0;
  for (int k = 0; k < 4; ++k) {
    ivec2 corner = ivec2(k & 1, k >> 1);
    vec2 shares = mix(1.0 - share, share, vec2(corner));
    seen[k] = seenBy(cell + corner, slope, place, fine);
    seen[k].z *= shares.x * shares.y;
    total += seen[k].z;
  }
#else
  vec2 scale = 1.0 / vec2(textureSize(factors, 0).xy);
#endif

  vec3 radiance = vec3(0.0);
  // A loop: software renderers take both sides of a branch.
  int last = blend > 0.0 ? min(fine + 1, LEVELS - 1) : fine;
  for (int level = fine; level <= last; ++level) {
    float weight = level == fine ? 1.0 - blend : blend;
#ifdef RELIEF_STEPS
    ivec3 texels[4];
    for (int k = 0; k < 4; ++k)
      texels[k] = ivec3(texelAt(level, seen[k].xy) * ivec2(ALL_GROUPS, 1), (cell.y + (k >> 1)) * VIEWS + cell.x + (k & 1));
#else
    // Linear between the middles of cells, by the hardware; never into the block beside.
    vec2 at = (vec2(texelAt(level, place) * VIEWS) + view + 0.5) * scale;
#endif
    for (int g = 0; g < GROUPS; ++g) {
#ifdef RELIEF_STEPS
      vec4 factor = vec4(0.0);
      for (int k = 0; k < 4; ++k) factor += seen[k].z / total * texelFetch(factors, texels[k] + ivec3(first_group + g, 0, 0), 0);
#else
      vec4 factor = textureLod(factors, vec3(at, first_group + g), 0.0);
#endif
      radiance += weight * vec3(dot(factor, incident[3 * g]), dot(factor, incident[3 * g + 1]), dot(factor, incident[3 * g + 2]));
    }
  }
  linear = vec4(radiance, alpha);
}
