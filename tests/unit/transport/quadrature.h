// Exact quadrature over the sphere for the tests: Gauss–Legendre in z, trapezoid in longitude.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "transport/gauss_legendre.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

struct WeightedDirection {
  Vec3 direction;
  double weight_sr;
};

// Exact for spherical polynomials of degree up to `degree`.
inline std::vector<WeightedDirection> sphereQuadrature(int degree) {
  std::vector<WeightedDirection> rule;
  const int columns = degree + 1;
  for (const auto& [z, weight] : gaussLegendreRule(degree / 2 + 1))
    for (int j = 0; j < columns; ++j) {
      const double phi = 2 * std::numbers::pi * (j + 0.5) / columns, r = std::sqrt(1 - z * z);
      rule.push_back(
          {Vec3(r * std::cos(phi), r * std::sin(phi), z), weight * 2 * std::numbers::pi / columns});
    }
  return rule;
}

}  // namespace bakelight::transport
