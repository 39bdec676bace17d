// The pyramid of a factored patch: what minification looks up.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace bakelight::formats {

// Of values at texels of the finest level, `a_texel` at each: those of all levels, in the order of rttLevels. A texel has the mean over
// the texels of the finest level that it covers, by shares where it covers parts. Views are taken through a plane by parallel rays, so
// the mean over an area is what that area sends towards a view, exactly.
std::vector<float> withLevels(std::span<const float> finest, int width, int height, std::size_t a_texel);

}  // namespace bakelight::formats
