// Weighted sums over rows of a table. The kernels are compiled for several instruction sets; they never sum across
// lanes and never fuse a multiplication with an addition, so each of them gives the same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace bakelight::transport {

// Rows are padded with zeros to whole tiles.
inline constexpr std::size_t kTile = 32;
constexpr std::size_t paddedToTiles(std::size_t count) {
  return (count + kTile - 1) / kTile * kTile;
}

// sums[i] += Σ_k weights[k] · table[chosen[k] · row_size + i] for all of sums, whose size is a multiple of kTile and
// at most row_size. Float sums of 128 rows go into doubles, so that the error does not grow with the number of rows.
void accumulateRows(const float* table, std::size_t row_size, std::span<const std::uint32_t> chosen,
                    std::span<const float> weights, std::span<double> sums);

}  // namespace bakelight::transport
