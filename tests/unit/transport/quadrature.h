// Exact quadrature over the sphere for the tests: Gauss–Legendre in z, trapezoid in longitude.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include "transport/vector_types.h"

namespace bakelight::transport {

// Nodes and weights on [-1, 1], exact for polynomials of degree 2n-1; Newton's iteration on P_n.
inline std::vector<std::pair<double, double>> gaussLegendre(int n) {
  std::vector<std::pair<double, double>> rule;
  for (int i = 0; i < n; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5)), slope = 0;
    for (int iteration = 0; iteration < 50; ++iteration) {
      double below = 1, here = x;
      for (int l = 2; l <= n; ++l)
        below = std::exchange(here, ((2 * l - 1) * x * here - (l - 1) * below) / l);
      slope = n * (x * here - below) / (x * x - 1);
      const double step = here / slope;
      x -= step;
      if (std::abs(step) < 1e-16) break;
    }
    rule.emplace_back(x, 2 / ((1 - x * x) * slope * slope));
  }
  return rule;
}

struct WeightedDirection {
  Vec3 direction;
  double weight_sr;
};

// Exact for spherical polynomials of degree up to `degree`.
inline std::vector<WeightedDirection> sphereQuadrature(int degree) {
  std::vector<WeightedDirection> rule;
  const int columns = degree + 1;
  for (const auto& [z, weight] : gaussLegendre(degree / 2 + 1))
    for (int j = 0; j < columns; ++j) {
      const double phi = 2 * std::numbers::pi * (j + 0.5) / columns, r = std::sqrt(1 - z * z);
      rule.push_back(
          {Vec3(r * std::cos(phi), r * std::sin(phi), z), weight * 2 * std::numbers::pi / columns});
    }
  return rule;
}

}  // namespace bakelight::transport
