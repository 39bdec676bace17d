#include "tools/transfer/near_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "transport/sh.h"

namespace bakelight::transfer {

using transport::Vec3;

void nearFieldDifference(const VirtualSphere& sphere, const Vec3& point, int order,
                         const Quadrature& quadrature, std::span<const std::uint32_t> visible_directions,
                         std::span<const float> cosines, std::span<double> difference) {
  const Vec3 from_center = (point - sphere.center) / sphere.radius;
  const double inside = 1 - from_center.squaredNorm();
  const std::size_t count = transport::coefficientCount(order);
  std::array<double, transport::coefficientCount(transport::kMaxOrder)> basis;
  std::fill(difference.begin(), difference.end(), 0.0);
  for (std::size_t k = 0; k < visible_directions.size(); ++k) {
    const std::uint32_t d = visible_directions[k];
    const auto& rays = quadrature.directions();
    const Vec3 s(rays.x[d], rays.y[d], rays.z[d]);
    // Exit from the unit sphere: |from_center + t s| = 1; there cos θ' = c · s = b + t with b = from_center ·
    // s.
    const double b = from_center.dot(s), cos_wall = std::sqrt(std::max(b * b + inside, 0.0));
    const Vec3 wall = from_center + (cos_wall - b) * s;
    transport::evaluateSh(order, wall.normalized(), std::span(basis).first(count));
    const float* distant = quadrature.row(d);
    const double weight = cosines[k];
    for (std::size_t i = 0; i < count; ++i) difference[i] += weight * (basis[i] / cos_wall - distant[i]);
  }
  for (std::size_t i = 0; i < count; ++i) difference[i] *= quadrature.weight() / std::numbers::pi;
}

}  // namespace bakelight::transfer
