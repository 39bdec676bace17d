// A light on the GPU, in the object's frame: what techniques take.
#pragma once

#include <cstdint>
#include <span>

#include "tools/player/gl/gl_objects.h"
#include "transport/lights.h"

namespace bakelight::player {

struct GpuLight {
  // 100 × RGB and padding, whatever the order: a uniform block `vec4 light[100]`.
  Buffer sh;
  // Another one with each change, so that a technique evaluates a light again only if it has changed.
  std::uint64_t revision = 0;
};

GpuLight darkLight();

// Uploads `light`; further coefficients become zero. Throws Error(kBadInput) naming the coefficient if one is
// not finite, std::invalid_argument for more than 100.
void setLight(GpuLight& gpu_light, std::span<const transport::Float3> light);

}  // namespace bakelight::player
