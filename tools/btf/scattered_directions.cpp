#include "tools/btf/scattered_directions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "tools/btf/triangulation.h"

namespace bakelight::btf {
namespace {

PlanePoint planeOf(const Vec3& direction) {
  return {direction.x() / (1 + direction.z()), direction.y() / (1 + direction.z())};
}

double cross(const PlanePoint& a, const PlanePoint& b, const PlanePoint& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

// Edges that one triangle has; without triangles the path through points on a line.
std::vector<std::array<int, 2>> borderOf(std::span<const PlanePoint> points,
                                         std::span<const std::array<int, 3>> triangles) {
  std::vector<std::array<int, 2>> border;
  if (triangles.empty()) {
    std::vector<int> order(points.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::sort(order, {}, [&](int i) { return std::pair(points[static_cast<std::size_t>(i)], i); });
    for (std::size_t i = 0; i + 1 < order.size(); ++i) border.push_back({order[i], order[i + 1]});
    if (border.empty()) border.push_back({order[0], order[0]});
    return border;
  }
  std::map<std::array<int, 2>, int> uses;
  for (const auto& [a, b, c] : triangles)
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
      ++uses[{std::min(from, to), std::max(from, to)}];
  for (const auto& [edge, count] : uses)
    if (count == 1) border.push_back(edge);
  return border;
}

}  // namespace

Vec3 vectorOf(const formats::BtfDirection& direction) {
  const double sine = std::sin(direction.polar_rad);
  return {sine * std::cos(direction.azimuth_rad), sine * std::sin(direction.azimuth_rad),
          std::max(std::cos(direction.polar_rad), 0.0)};
}

ScatteredDirections::ScatteredDirections(std::span<const Vec3> directions) {
  if (directions.empty()) throw std::invalid_argument("ScatteredDirections: no direction");
  for (const Vec3& direction : directions) points_.push_back(planeOf(direction));
  triangles_ = delaunayTriangles(points_);
  border_ = borderOf(points_, triangles_);
}

std::vector<ScatteredDirections::Share> ScatteredDirections::shares(const Vec3& direction) const {
  const PlanePoint p = planeOf(direction);
  const auto point = [&](int i) -> const PlanePoint& { return points_[static_cast<std::size_t>(i)]; };
  const auto kept = [](std::initializer_list<Share> all) {
    std::vector<Share> shares;
    for (const Share& share : all)
      if (share.weight > 0) shares.push_back(share);
    return shares;
  };
  for (const auto& [a, b, c] : triangles_) {
    const double area = cross(point(a), point(b), point(c));
    const double of_a = cross(p, point(b), point(c)), of_b = cross(point(a), p, point(c));
    const double of_c = area - of_a - of_b;
    const double rounding = -1e-12 * area;
    if (of_a < rounding || of_b < rounding || of_c < rounding) continue;
    const double w_a = std::max(of_a, 0.0), w_b = std::max(of_b, 0.0), w_c = std::max(of_c, 0.0);
    const double sum = w_a + w_b + w_c;
    if (sum > 0) return kept({{a, w_a / sum}, {b, w_b / sum}, {c, w_c / sum}});
  }
  std::array<int, 2> nearest = border_.front();
  double nearest_share = 0, nearest_square = INFINITY;
  for (const auto& [a, b] : border_) {
    const double x = point(b)[0] - point(a)[0], y = point(b)[1] - point(a)[1], length = x * x + y * y;
    const double along = (p[0] - point(a)[0]) * x + (p[1] - point(a)[1]) * y;
    const double share = length > 0 ? std::clamp(along / length, 0.0, 1.0) : 0;
    const double dx = point(a)[0] + share * x - p[0], dy = point(a)[1] + share * y - p[1];
    if (dx * dx + dy * dy >= nearest_square) continue;
    nearest_square = dx * dx + dy * dy, nearest = {a, b}, nearest_share = share;
  }
  return kept({{nearest[0], 1 - nearest_share}, {nearest[1], nearest_share}});
}

}  // namespace bakelight::btf
