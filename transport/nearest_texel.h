// For each texel the nearest of those in a set.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace bakelight::transport {

// Indices y · width + x, by exact Euclidean distance; of equally near ones the leftmost, of these the
// topmost. A. Meijster, J. Roerdink, W. Hesselink: A general algorithm for computing distance transforms in
// linear time, 2000. `members` has one byte a texel; one at least is not 0.
std::vector<std::uint32_t> nearestTexels(std::span<const std::uint8_t> members, int width, int height);

}  // namespace bakelight::transport
