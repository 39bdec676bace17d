#include "transport/row_sums.h"

#include <algorithm>
#include <array>

#include "transport/multiversioned.h"

namespace bakelight::transport {

namespace {

// One tile of coefficients at a time, so that its sums stay in registers.
BAKELIGHT_MULTIVERSIONED void accumulateTiles(const float* table, std::size_t row_size, std::size_t used,
                                              const std::uint32_t* chosen, const float* weights,
                                              std::size_t count, double* sums) {
  constexpr std::size_t kBlock = 128;
  for (std::size_t first = 0; first < count; first += kBlock) {
    const std::size_t end = std::min(first + kBlock, count);
    for (std::size_t tile = 0; tile < used; tile += kTile) {
      std::array<float, kTile> partial{};
      for (std::size_t k = first; k < end; ++k) {
        const float* row = table + chosen[k] * row_size + tile;
        const float weight = weights[k];
        for (std::size_t i = 0; i < kTile; ++i) partial[i] += weight * row[i];
      }
      for (std::size_t i = 0; i < kTile; ++i) sums[tile + i] += partial[i];
    }
  }
}

}  // namespace

void accumulateRows(const float* table, std::size_t row_size, std::span<const std::uint32_t> chosen,
                    std::span<const float> weights, std::span<double> sums) {
  accumulateTiles(table, row_size, sums.size(), chosen.data(), weights.data(), chosen.size(), sums.data());
}

}  // namespace bakelight::transport
