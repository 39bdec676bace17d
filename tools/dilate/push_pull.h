// Smooth values for holes, from a pyramid of averages.
#pragma once

#include <cstdint>
#include <span>

#include "formats/image.h"

namespace bakelight::dilate {

// A texel of a coarser level is the mean of those of its four that have a value; coarser levels, bilinear
// between their texels, fill the holes of finer ones (Gortler et al. 1996, section 3.4.2, with weights of 0
// and 1). Texels with a byte other than 0 keep their values. Cost: O(texels · channels).
formats::Image pushPull(const formats::Image& image, std::span<const std::uint8_t> covered);

}  // namespace bakelight::dilate
