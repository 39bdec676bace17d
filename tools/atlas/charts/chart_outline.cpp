#include "tools/atlas/charts/chart_outline.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace bakelight::atlas {
namespace {

using Edge = std::array<std::uint32_t, 2>;

std::vector<Edge> borderEdges(const std::vector<Triangle>& triangles) {
  // Sorted by ends, both directions of an edge together.
  std::vector<std::pair<Edge, int>> directed;
  directed.reserve(3 * triangles.size());
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      if (a == b) continue;
      directed.push_back({{std::min(a, b), std::max(a, b)}, a < b ? 1 : -1});
    }
  std::sort(directed.begin(), directed.end());
  std::vector<Edge> result;
  for (std::size_t i = 0; i < directed.size();) {
    const Edge edge = directed[i].first;
    int surplus = 0;
    for (; i < directed.size() && directed[i].first == edge; ++i) surplus += directed[i].second;
    for (; surplus > 0; --surplus) result.push_back(edge);
    for (; surplus < 0; ++surplus) result.push_back({edge[1], edge[0]});
  }
  return result;
}

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Andrew's monotone chain.
std::vector<Vec2> convexHull(std::vector<Vec2> points) {
  const auto less = [](const Vec2& a, const Vec2& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  };
  std::sort(points.begin(), points.end(), less);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Vec2> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t begin = hull.size();
    for (const Vec2& p : points) {
      while (hull.size() >= begin + 2 && cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0)
        hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

double uprightAngle(const std::vector<Vec2>& hull) {
  double best_area = std::numeric_limits<double>::infinity(), best = 0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vec2 edge = hull[(i + 1) % hull.size()] - hull[i];
    const double angle = -std::atan2(edge.y(), edge.x());
    const auto [low, high] = turnedBox(hull, angle);
    const Vec2 size = high - low;
    if (size.prod() >= best_area) continue;
    best_area = size.prod();
    best = size.x() >= size.y() ? angle : angle + std::numbers::pi / 2;
  }
  return best;
}

}  // namespace

ChartOutline outlineOf(const FlatChart& chart) {
  ChartOutline outline;
  outline.edges = borderEdges(chart.triangles);
  std::vector<std::uint32_t> used;
  for (const Edge& edge : outline.edges) used.insert(used.end(), edge.begin(), edge.end());
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  for (const std::uint32_t v : used) outline.vertices.push_back(chart.vertices[v]);
  for (Edge& edge : outline.edges)
    for (std::uint32_t& end : edge)
      end = static_cast<std::uint32_t>(std::lower_bound(used.begin(), used.end(), end) - used.begin());
  for (const Triangle& t : chart.triangles) {
    const Vec2& a = chart.vertices[t[0]];
    outline.area += cross(chart.vertices[t[1]] - a, chart.vertices[t[2]] - a) / 2;
  }
  outline.hull = convexHull(outline.vertices);
  outline.upright_angle_rad = uprightAngle(outline.hull);
  return outline;
}

std::array<Vec2, 2> turnedBox(const std::vector<Vec2>& points, double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec2 low(kInfinity, kInfinity), high(-kInfinity, -kInfinity);
  for (const Vec2& p : points) {
    const Vec2 turned(c * p.x() - s * p.y(), s * p.x() + c * p.y());
    low = low.cwiseMin(turned);
    high = high.cwiseMax(turned);
  }
  return {low, high};
}

}  // namespace bakelight::atlas
