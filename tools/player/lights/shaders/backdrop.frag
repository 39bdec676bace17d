// The environment seen past the object: the same bilinear lookup as transport::lookUpLatLong. Texels are fetched and
// weighed here, since texture filters are allowed to round the weights to 8 bits.
layout(location = 0) uniform vec2 size_px;
// Through the middle of the picture, and what half its width and height add; in the light's frame.
layout(location = 1) uniform vec3 forward;
layout(location = 2) uniform vec3 right;
layout(location = 3) uniform vec3 up;
layout(binding = 0) uniform sampler2D environment;  // row 0 is +Y, the middle column +Z

layout(location = 0) out vec4 linear;

const float kPi = 3.14159265358979;

// atan2(y, x) to a rounding or two, also at (0, 0): drivers' own are off by up to 1e-5, which shows at the edge of a light
// source. Reduction and polynomial of the Cephes library's atanf.
float angleOf(float y, float x) {
  float larger = max(abs(x), abs(y)), smaller = min(abs(x), abs(y));
  if (larger == 0.0) return 0.0;
  bool beyond_eighth = smaller > 0.41421356 * larger;
  float t = beyond_eighth ? (smaller - larger) / (smaller + larger) : smaller / larger;
  float t2 = t * t;
  float angle =
      (((8.05374449538e-2 * t2 - 1.38776856032e-1) * t2 + 1.99777106478e-1) * t2 - 3.33329491539e-1) * t2 * t + t;
  if (beyond_eighth) angle += 0.25 * kPi;
  if (abs(y) > abs(x)) angle = 0.5 * kPi - angle;
  if (x < 0.0) angle = kPi - angle;
  return y < 0.0 ? -angle : angle;
}

vec3 texel(ivec2 at, ivec2 size) {
  return texelFetch(environment, ivec2((at.x + size.x) % size.x, clamp(at.y, 0, size.y - 1)), 0).rgb;
}

void main() {
  vec2 ndc = gl_FragCoord.xy / size_px * 2.0 - 1.0;
  vec3 direction = forward + ndc.x * right + ndc.y * up;
  float longitude = angleOf(-direction.x, direction.z);  // 0 along +Z, which is the middle column
  float colatitude = angleOf(length(direction.xz), direction.y);

  ivec2 size = textureSize(environment, 0);
  vec2 position = vec2(longitude / (2.0 * kPi) + 0.5, colatitude / kPi) * vec2(size) - 0.5;
  vec2 corner = floor(position);
  vec2 weight = position - corner;
  ivec2 at = ivec2(corner);
  vec3 top = mix(texel(at, size), texel(at + ivec2(1, 0), size), weight.x);
  vec3 bottom = mix(texel(at + ivec2(0, 1), size), texel(at + ivec2(1, 1), size), weight.x);
  linear = vec4(mix(top, bottom, weight.y), 1.0);
}
