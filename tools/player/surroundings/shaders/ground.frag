// A ground that fades out before it ends (transport::GroundFade); premultiplied. Definitions: FADE_START.
in vec3 exit_radiance;
in vec2 place;

layout(location = 1) uniform vec2 middle;
layout(location = 2) uniform vec2 half_size;

layout(location = 0) out vec4 linear;

void main() {
  float t = clamp((length((place - middle) / half_size) - FADE_START) / (1.0 - FADE_START), 0.0, 1.0);
  float opacity = 1.0 - t * t * (3.0 - 2.0 * t);
  linear = vec4(exit_radiance * opacity, opacity);
}
