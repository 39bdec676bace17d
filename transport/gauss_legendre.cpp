#include "transport/gauss_legendre.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace bakelight::transport {

std::vector<QuadratureNode> gaussLegendreRule(int count) {
  constexpr int kNewtonSteps = 50;  // five are enough; the loop ends at rounding
  std::vector<QuadratureNode> rule;
  rule.reserve(count);
  for (int i = 0; i < count; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (count + 0.5));  // Tricomi's estimate of the root
    if (count % 2 == 1 && i == count / 2) x = 0;
    double slope = 0;
    for (int iteration = 0; iteration < kNewtonSteps; ++iteration) {
      double below = 1, here = x;
      for (int l = 2; l <= count; ++l)
        below = std::exchange(here, ((2 * l - 1) * x * here - (l - 1) * below) / l);
      slope = count * (x * here - below) / (x * x - 1);
      const double step = here / slope;
      x -= step;
      if (std::abs(step) < 1e-16) break;
    }
    rule.push_back({x, 2 / ((1 - x * x) * slope * slope)});
  }
  return rule;
}

}  // namespace bakelight::transport
