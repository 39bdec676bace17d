// B(q(u), v) · (M L) of a pixel (transport::BiScaleShading). Definitions: GROUPS; VIEWS, a side of the grid of views;
// LEVELS of the pyramid; INDEX if an image says where in the patch a texel is.
in vec3 surface_position, surface_normal;
in vec4 surface_tangent;
in vec2 surface_texcoord;
in vec4 incident[3 * GROUPS];

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

layout(binding = 0) uniform sampler2DArray factors;  // blocks of views, side by side as texels are

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

// Where in the texture of factors the views of the place begin, at a level: all four components of a layer there.
vec2 blockOf(int level, vec2 place) {
  ivec4 part = levels[level];
  ivec2 texel = clamp(ivec2(vec2(place.x, 1.0 - place.y) * vec2(part.zw)), ivec2(0), part.zw - 1);
  return vec2((part.xy + texel) * VIEWS);
}

void main() {
  vec3 n = normalize(surface_normal);
  vec3 t = normalize(surface_tangent.xyz - dot(surface_tangent.xyz, n) * n);
  vec3 b = surface_tangent.w * cross(n, t);
  vec3 offset = eye - surface_position;
  float distance_to_eye = length(offset);
  vec3 to_eye = offset / distance_to_eye;
  vec3 local_eye = vec3(dot(to_eye, t), dot(to_eye, b), dot(to_eye, n));
  // Linear between the middles of cells, by the hardware; never into the block beside.
  vec2 view = 0.5 + clamp(squareOf(local_eye) * float(VIEWS) - 0.5, 0.0, float(VIEWS) - 1.0);

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
  vec2 scale = 1.0 / vec2(textureSize(factors, 0).xy);
  vec2 near_by = (blockOf(fine, place) + view) * scale;
  vec2 coarser = (blockOf(min(fine + 1, LEVELS - 1), place) + view) * scale;

  vec3 radiance = vec3(0.0);
  for (int g = 0; g < GROUPS; ++g) {
    vec4 factor = textureLod(factors, vec3(near_by, first_group + g), 0.0);
    if (blend > 0.0) factor = mix(factor, textureLod(factors, vec3(coarser, first_group + g), 0.0), blend);
    radiance += vec3(dot(factor, incident[3 * g]), dot(factor, incident[3 * g + 1]), dot(factor, incident[3 * g + 2]));
  }
  linear = vec4(radiance, alpha);
}
