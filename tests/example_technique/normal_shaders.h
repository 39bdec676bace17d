// What a room of tools/player keeps in files of its shaders/ and has embedded.
#pragma once

#include "tools/player/gl/shader_sources.h"

namespace bakelight::example {

inline constexpr player::ShaderSource kNormalsVert = {"normals.vert", R"glsl(
layout(location = 0) in vec3 position;  // from the mesh's origin
layout(location = 1) in vec3 normal;

layout(location = 0) uniform mat4 clip_from_position;

out vec3 surface_position, surface_normal;

void main() {
  surface_position = position;
  surface_normal = normal;
  gl_Position = clip_from_position * vec4(position, 1.0);
}
)glsl"};

inline constexpr player::ShaderSource kNormalsFrag = {"normals.frag", R"glsl(
in vec3 surface_position, surface_normal;

layout(location = 1) uniform vec3 eye;  // where positions are
layout(binding = 0) uniform sampler2D picture;
layout(std140, binding = 0) uniform Light { vec4 light[100]; };
#ifdef NEAR_LIGHT
layout(std140, binding = 1) uniform NearLight { vec4 near_light[100]; };
#endif

layout(location = 0) out vec4 linear;

// Where the ball has the normal, from -1 to 1: to the right and upwards as the eye sees it.
vec2 placeOnBall(vec3 normal, vec3 to_eye) {
  vec3 upwards = abs(to_eye.y) < 0.999 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0);
  vec3 right = normalize(cross(upwards, to_eye));
  return vec2(dot(normal, right), dot(normal, cross(to_eye, right)));
}

vec3 texelAt(ivec2 at) {
  return texelFetch(picture, clamp(at, ivec2(0), textureSize(picture, 0) - 1), 0).rgb;
}

// At full precision, which the hardware's filter does not have.
vec3 lookUp(vec2 place) {
  vec2 position = (0.5 + vec2(0.5, -0.5) * place) * vec2(textureSize(picture, 0)) - 0.5;
  ivec2 corner = ivec2(floor(position));
  vec2 weight = position - floor(position);
  vec3 top = mix(texelAt(corner), texelAt(corner + ivec2(1, 0)), weight.x);
  vec3 bottom = mix(texelAt(corner + ivec2(0, 1)), texelAt(corner + ivec2(1, 1)), weight.x);
  return mix(top, bottom, weight.y);
}

void main() {
  vec3 mean_radiance = 0.28209479 * light[0].rgb;
#ifdef NEAR_LIGHT
  mean_radiance += 0.28209479 * near_light[0].rgb;
#endif
  vec2 place = placeOnBall(normalize(surface_normal), normalize(eye - surface_position));
  linear = vec4(mean_radiance * lookUp(place), 1.0);
}
)glsl"};

}  // namespace bakelight::example
