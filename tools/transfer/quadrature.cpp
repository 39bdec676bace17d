#include "tools/transfer/quadrature.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <numbers>

#include "transport/directions.h"
#include "transport/sh.h"

namespace bakelight::transfer {

using transport::Vec3;

// Sanitizers are not ready yet when the loader chooses among the clones.
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define BAKELIGHT_MULTIVERSIONED __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define BAKELIGHT_MULTIVERSIONED
#endif

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

// Every direction is written and the end moves on only past those above, as the branch would be mispredicted
// too often.
BAKELIGHT_MULTIVERSIONED std::size_t collectAbove(const transport::RayBundle& directions,
                                                  const Float3& normal, Hemisphere& hemisphere) {
  const float* const x = directions.x.data();
  const float* const y = directions.y.data();
  const float* const z = directions.z.data();
  std::size_t end = 0;
  for (std::size_t d = 0; d < directions.size(); ++d) {
    const float cosine = normal[0] * x[d] + normal[1] * y[d] + normal[2] * z[d];
    hemisphere.rays.x[end] = x[d];
    hemisphere.rays.y[end] = y[d];
    hemisphere.rays.z[end] = z[d];
    hemisphere.directions[end] = static_cast<std::uint32_t>(d);
    hemisphere.cosines[end] = cosine;
    end += cosine > 0 ? 1 : 0;
  }
  return end;
}

}  // namespace

void accumulateRows(const float* table, std::size_t row_size, std::span<const std::uint32_t> chosen,
                    std::span<const float> weights, std::span<double> sums) {
  accumulateTiles(table, row_size, row_size, chosen.data(), weights.data(), chosen.size(), sums.data());
}

Quadrature::Quadrature(int order, int count)
    : row_size_(paddedToTiles(transport::coefficientCount(order))),
      directions_(count),
      basis_(count * row_size_, 0.0f),
      weight_(4 * std::numbers::pi / count) {
  const std::vector<Vec3> lattice = transport::sphereDirections(count);
  tbb::parallel_for(0, count, [&](int d) {
    directions_.set(d, transport::float3(lattice[d]));
    std::array<double, transport::coefficientCount(transport::kMaxEvaluatedOrder)> values;
    const int used = transport::coefficientCount(order);
    transport::evaluateSh(order, lattice[d], std::span(values).first(used));
    std::copy_n(values.begin(), used, &basis_[d * row_size_]);
  });
}

void Quadrature::accumulate(std::span<const std::uint32_t> chosen, std::span<const float> weights,
                            std::size_t coefficients, std::span<double> sums) const {
  accumulateTiles(basis_.data(), row_size_, paddedToTiles(coefficients), chosen.data(), weights.data(),
                  chosen.size(), sums.data());
}

void Hemisphere::collect(const Quadrature& quadrature, const Float3& normal) {
  count = collectAbove(quadrature.directions(), normal, *this);
}

}  // namespace bakelight::transfer
