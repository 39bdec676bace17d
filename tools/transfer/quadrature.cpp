#include "tools/transfer/quadrature.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <Eigen/Geometry>
#include <numbers>

#include "transport/diffusion.h"
#include "transport/directions.h"
#include "transport/multiversioned.h"
#include "transport/random.h"
#include "transport/sh.h"

namespace bakelight::transfer {

using transport::Vec3;

namespace {

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

// Evenly distributed rotations (Shoemake 1992, "Uniform Random Rotations").
Eigen::Matrix3d randomTurn(std::uint32_t number) {
  const auto random = [&](std::uint64_t dimension) {
    return 0x1p-64 * static_cast<double>(transport::scrambled(transport::scrambled(number) ^ dimension));
  };
  const double share = random(0), a = 2 * std::numbers::pi * random(1), b = 2 * std::numbers::pi * random(2);
  const double r = std::sqrt(1 - share), s = std::sqrt(share);
  return Eigen::Quaterniond(s * std::cos(b), r * std::sin(a), r * std::cos(a), s * std::sin(b))
      .toRotationMatrix();
}

}  // namespace

Quadrature::Quadrature(int order, int count, std::uint32_t turn)
    : row_size_(transport::paddedToTiles(transport::coefficientCount(order))),
      directions_(count),
      basis_(count * row_size_, 0.0f),
      weight_(4 * std::numbers::pi / count) {
  std::vector<Vec3> lattice = transport::sphereDirections(count);
  if (turn > 0) {
    const Eigen::Matrix3d turned = randomTurn(turn);
    for (Vec3& direction : lattice) direction = (turned * direction).normalized();
  }
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
  transport::accumulateRows(basis_.data(), row_size_, chosen, weights,
                            sums.first(transport::paddedToTiles(coefficients)));
}

void Hemisphere::collect(const Quadrature& quadrature, const Float3& normal) {
  count = collectAbove(quadrature.directions(), normal, *this);
}

std::vector<double> cosineFactors(int order, double entered_ior) {
  return entered_ior > 0 ? transport::enteringCosineFactors(order, entered_ior)
                         : transport::clampedCosineFactors(order);
}

void Hemisphere::enter(double relative_ior) {
  for (std::size_t k = 0; k < count; ++k)
    cosines[k] *=
        static_cast<float>(transport::schlickTransmittance(static_cast<double>(cosines[k]), relative_ior));
}

}  // namespace bakelight::transfer
