#include "transport/hemisphere_grid.h"

#include <algorithm>
#include <array>
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

namespace {

// Of [x0, x1] × [y0, y1] with 0 ≤ x0, 0 ≤ y0: ∫∫ max(x, y)² dy dx.
double squaredRadius(double x0, double x1, double y0, double y1) {
  if (x0 >= y1) return (x1 * x1 * x1 - x0 * x0 * x0) / 3 * (y1 - y0);
  if (y0 >= x1) return (y1 * y1 * y1 - y0 * y0 * y0) / 3 * (x1 - x0);
  // ∫ of the inner one, ∫ max(x, y)² dy = x² (m − y0) + (y1³ − m³)/3 with m = clamp(x, y0, y1), over its three parts.
  const auto below = [&](double x) { return x * (y1 * y1 * y1 - y0 * y0 * y0) / 3; };
  const auto within = [&](double x) {
    return x * x * x * x / 4 - y0 * x * x * x / 3 + y1 * y1 * y1 * x / 3 - x * x * x * x / 12;
  };
  const auto above = [&](double x) { return x * x * x / 3 * (y1 - y0); };
  const double first = std::clamp(y0, x0, x1), last = std::clamp(y1, x0, x1);
  return below(first) - below(x0) + within(last) - within(first) + above(x1) - above(last);
}

}  // namespace

double hemisphereCellCosine(int side, int column, int row) {
  // Of the disk's square, −1 to 1; z = 1 − max(|x|, |y|)². Cells across an axis are cut there.
  const auto parts = [side](int cell) {
    const double low = 2.0 * cell / side - 1, high = 2.0 * (cell + 1) / side - 1;
    if (low >= 0) return std::array{std::array{low, high}, std::array{0.0, 0.0}};
    if (high <= 0) return std::array{std::array{-high, -low}, std::array{0.0, 0.0}};
    return std::array{std::array{0.0, -low}, std::array{0.0, high}};
  };
  double sum = 0;
  for (const auto& x : parts(column))
    for (const auto& y : parts(row)) sum += squaredRadius(x[0], x[1], y[0], y[1]);
  return 1 - sum * side * side / 4;
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
