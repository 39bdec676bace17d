// SH coefficients of a light on the GPU.
#pragma once

#include <span>

#include "tools/player/gl_objects.h"
#include "transport/lights.h"

namespace bakelight::player {

// 100 × RGB and padding, whatever the order: a uniform block `vec4 light[100]`. Zero until it is set.
Buffer makeLightBuffer();

// Uploads `light`; further coefficients become zero. Throws Error(kBadInput) naming the coefficient if one is
// not finite, std::invalid_argument for more than 100.
void setLight(const Buffer& buffer, std::span<const transport::Float3> light);

}  // namespace bakelight::player
