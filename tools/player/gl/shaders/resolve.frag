// From linear subsamples to the picture: box filter, then exposure and display code (transport/color.h).
layout(location = 0) uniform int supersampling;  // per axis
layout(location = 1) uniform float exposure;
layout(location = 2) uniform bool display_encoded;  // otherwise linear, premultiplied, unexposed
layout(binding = 0) uniform sampler2D subsamples;

layout(location = 0) out vec4 picture;

float srgbFromLinear(float linear) {
  if (!(linear > 0.0)) return 0.0;
  if (linear >= 1.0) return 1.0;
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1.0 / 2.4) - 0.055;
}

void main() {
  ivec2 first = ivec2(gl_FragCoord.xy) * supersampling;
  vec4 sum = vec4(0.0);
  for (int y = 0; y < supersampling; ++y)
    for (int x = 0; x < supersampling; ++x) sum += texelFetch(subsamples, first + ivec2(x, y), 0);
  vec4 mean = sum / float(supersampling * supersampling);
  if (!display_encoded) {
    picture = mean;
    return;
  }
  // PNG wants colour that is not multiplied by coverage.
  vec3 color = mean.a > 0.0 ? mean.rgb * (exposure / mean.a) : vec3(0.0);
  picture = vec4(srgbFromLinear(color.r), srgbFromLinear(color.g), srgbFromLinear(color.b), mean.a);
}
