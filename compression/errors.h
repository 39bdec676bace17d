// How far a compressed transfer's incident radiance is from what it stands for.
#pragma once

#include <span>
#include <vector>

#include "compression/compressed_transfer.h"

namespace bakelight::compression {

// √(Σ |value − truth|² ÷ Σ |truth|²) over rows and colors; 0 ÷ 0 is 0.
double relativeRms(std::span<const Radiance4> values, std::span<const Radiance4> truth);

// `light` as multiply takes it, from mean radiance a texel.
std::vector<Radiance4> texelEnergies(std::span<const formats::Float3> radiance, int cube_side);

}  // namespace bakelight::compression
