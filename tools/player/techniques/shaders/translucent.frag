// Of what comes out below the surface, the share that leaves towards the eye (Schlick 1994).
in vec3 surface_position, surface_normal, surface_stain;
in vec2 surface_texcoord;

layout(location = 1) uniform vec3 eye;
layout(location = 2) uniform float normal_reflectance;
layout(binding = 0) uniform sampler2D radiosity;  // rows from the top; alpha 1 where there is any

layout(location = 0) out vec4 linear;

void main() {
  ivec2 size = textureSize(radiosity, 0);
  vec2 place = vec2(surface_texcoord.x, 1.0 - surface_texcoord.y) * vec2(size) - 0.5;
  ivec2 corner = ivec2(floor(place));
  vec2 share = place - vec2(corner);
  vec4 sum = vec4(0.0);
  for (int dy = 0; dy < 2; ++dy)
    for (int dx = 0; dx < 2; ++dx) {
      vec2 weight = mix(1.0 - share, share, vec2(dx, dy));
      sum += weight.x * weight.y * texelFetch(radiosity, clamp(corner + ivec2(dx, dy), ivec2(0), size - 1), 0);
    }
  float cosine = abs(dot(normalize(surface_normal), normalize(eye - surface_position)));
  float leaving = (1.0 - normal_reflectance) * (1.0 - pow(1.0 - cosine, 5.0)) / 3.14159265358979;
  linear = vec4(sum.a > 0.0 ? surface_stain * leaving * sum.rgb / sum.a : vec3(0.0), 1.0);
}
