#include "transport/hemisphere_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bakelight::transport {

Vec3 hemisphereFromSquare(double a, double b) {
  const double x = 2 * a - 1, y = 2 * b - 1;
  if (x == 0 && y == 0) return Vec3(0, 0, 1);
  constexpr double kQuarter = std::numbers::pi / 4;
  const bool flat = std::abs(x) > std::abs(y);
  const double radius = flat ? x : y;  // signed: opposite wedges share their angle's formula
  const double angle = flat ? kQuarter * (y / x) : std::numbers::pi / 2 - kQuarter * (x / y);
  const double squared = std::min(radius * radius, 1.0);
  const double across = radius * std::sqrt(2 - squared);
  return Vec3(across * std::cos(angle), across * std::sin(angle), 1 - squared);
}

SquarePoint squareFromHemisphere(const Vec3& direction) {
  const double flat = std::hypot(direction.x(), direction.y()), z = std::max(direction.z(), 0.0);
  const double length = std::hypot(flat, z);
  if (flat == 0 || length == 0) return {};
  const double cosine = z / length;
  // √(1 − z) without cancellation near the zenith.
  const double radius = (flat / length) / std::sqrt(1 + cosine);
  const double x = std::abs(direction.x()), y = std::abs(direction.y());
  // Angle from the nearer axis, as a share of 45°.
  const double share = std::atan(std::min(x, y) / std::max(x, y)) / (std::numbers::pi / 4);
  const double across = x > y ? radius : radius * share, up = x > y ? radius * share : radius;
  return {(1 + std::copysign(across, direction.x())) / 2, (1 + std::copysign(up, direction.y())) / 2};
}

Vec3 hemisphereCell(int side, int column, int row) {
  return hemisphereFromSquare((column + 0.5) / side, (row + 0.5) / side);
}

GridPosition gridPosition(int side, const Vec3& direction) {
  if (side <= 1) return {};
  const SquarePoint point = squareFromHemisphere(direction);
  const auto split = [side](double at, int& cell, float& rest) {
    const double position = std::clamp(at * side - 0.5, 0.0, side - 1.0);
    cell = std::min(static_cast<int>(position), side - 2);
    rest = static_cast<float>(position - cell);
  };
  GridPosition position;
  split(point.a, position.column, position.across);
  split(point.b, position.row, position.up);
  return position;
}

}  // namespace bakelight::transport
