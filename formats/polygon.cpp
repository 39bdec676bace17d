#include "formats/polygon.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace bakelight::formats {
namespace {

using Double3 = std::array<double, 3>;

double dot(const Double3& a, const Double3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Double3 crossOfEdges(const Float3& a, const Float3& b, const Float3& c) {
  Double3 u, v;
  for (std::size_t k = 0; k < 3; ++k) {
    u[k] = static_cast<double>(b[k]) - a[k];
    v[k] = static_cast<double>(c[k]) - b[k];
  }
  return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}

// Newell's normal, its length twice the area; nothing for a polygon without area. Relative to its first
// corner, so that a small polygon far out keeps its bits.
std::optional<Double3> normalOf(std::span<const Float3> corners) {
  Double3 normal = {0, 0, 0};
  double circumference = 0;
  const auto edge = [&](std::size_t i, std::size_t k) {
    return static_cast<double>(corners[i][k]) - corners[0][k];
  };
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::size_t j = i + 1 == corners.size() ? 0 : i + 1;
    double length = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
      normal[k] += (edge(i, l) - edge(j, l)) * (edge(i, m) + edge(j, m));
      length += (edge(i, k) - edge(j, k)) * (edge(i, k) - edge(j, k));
    }
    circumference += std::sqrt(length);
  }
  constexpr double kFlat = 1e-12;  // of the circumference squared
  const double length = std::sqrt(dot(normal, normal));
  if (!std::isfinite(length) || length <= kFlat * circumference * circumference) return std::nullopt;
  return normal;
}

double turn(const std::array<double, 2>& a, const std::array<double, 2>& b, const std::array<double, 2>& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

bool appendFan(std::size_t count, std::vector<Triangle>& triangles) {
  for (std::uint32_t i = 1; i + 1 < count; ++i) triangles.push_back({0, i, i + 1});
  return false;
}

}  // namespace

bool PolygonTriangulator::splitQuad(std::span<const Float3> corners, std::vector<Triangle>& triangles) const {
  const auto normal = normalOf(corners);
  if (!normal) return appendFan(4, triangles);
  std::array<double, 4> turns;
  for (std::size_t i = 0; i < 4; ++i)
    turns[i] = dot(crossOfEdges(corners[(i + 3) % 4], corners[i], corners[(i + 1) % 4]), *normal);
  // The diagonal starts where the quadrilateral turns inwards or not at all.
  if (std::min(turns[1], turns[3]) <= 0 && std::min(turns[0], turns[2]) > 0) {
    triangles.push_back({0, 1, 3});
    triangles.push_back({1, 2, 3});
  } else {
    triangles.push_back({0, 1, 2});
    triangles.push_back({0, 2, 3});
  }
  return std::count_if(turns.begin(), turns.end(), [](double t) { return t < 0; }) <= 1;
}

bool PolygonTriangulator::triangulate(std::span<const Float3> corners, std::vector<Triangle>& triangles) {
  if (corners.size() == 3) {
    triangles.push_back({0, 1, 2});
    return true;
  }
  if (corners.size() == 4) return splitQuad(corners, triangles);
  const auto normal = normalOf(corners);
  if (!normal) return appendFan(corners.size(), triangles);

  // Seen along the axis nearest to the normal, so that the sense of rotation is kept.
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (std::abs((*normal)[k]) > std::abs((*normal)[axis])) axis = k;
  std::size_t x = (axis + 1) % 3, y = (axis + 2) % 3;
  if ((*normal)[axis] < 0) std::swap(x, y);
  points_.clear();
  for (const Float3& p : corners) points_.push_back({p[x], p[y]});

  start();
  bool simple = true, clipped_since_scan = true;
  while (remaining_ > 3) {
    if (queue_begin_ == queue_.size()) {
      // An obstacle that has gone may have made an ear of a corner far away: look at all once more.
      if (clipped_since_scan) {
        clipped_since_scan = false;
        enqueueAll();
        continue;
      }
      simple = false;  // a simple polygon has an ear (two, in fact)
      std::uint32_t best = some_corner_, corner = some_corner_;
      for (std::uint32_t i = 0; i < remaining_; ++i, corner = next_[corner])
        if (turnAt(corner) > turnAt(best)) best = corner;
      clip(best, triangles);
      clipped_since_scan = true;
      continue;
    }
    const auto [corner, entry] = queue_[queue_begin_++];
    if (entry != entries_[corner] || !isEar(corner)) continue;
    clip(corner, triangles);
    clipped_since_scan = true;
  }
  triangles.push_back({previous_[some_corner_], some_corner_, next_[some_corner_]});
  return simple;
}

void PolygonTriangulator::start() {
  const auto count = static_cast<std::uint32_t>(points_.size());
  remaining_ = count;
  some_corner_ = 0;
  previous_.resize(count);
  next_.resize(count);
  entries_.assign(count, 0);
  obstacle_.assign(count, 0);
  obstacles_by_x_.clear();
  for (std::uint32_t i = 0; i < count; ++i) {
    previous_[i] = i == 0 ? count - 1 : i - 1;
    next_[i] = i + 1 == count ? 0 : i + 1;
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    obstacle_[i] = turnAt(i) <= 0;
    if (obstacle_[i]) obstacles_by_x_.push_back(i);
  }
  std::sort(obstacles_by_x_.begin(), obstacles_by_x_.end(),
            [&](std::uint32_t a, std::uint32_t b) { return points_[a][0] < points_[b][0]; });
  enqueueAll();
}

void PolygonTriangulator::enqueueAll() {
  queue_.clear();
  queue_begin_ = 0;
  std::uint32_t corner = some_corner_;
  for (std::uint32_t i = 0; i < remaining_; ++i, corner = next_[corner])
    queue_.push_back({corner, ++entries_[corner]});
}

double PolygonTriangulator::turnAt(std::uint32_t corner) const {
  return turn(points_[previous_[corner]], points_[corner], points_[next_[corner]]);
}

bool PolygonTriangulator::isEar(std::uint32_t corner) const {
  const Point &a = points_[previous_[corner]], &b = points_[corner], &c = points_[next_[corner]];
  if (!(turn(a, b, c) > 0)) return false;
  const double x_min = std::min({a[0], b[0], c[0]}), x_max = std::max({a[0], b[0], c[0]});
  auto obstacle = std::lower_bound(obstacles_by_x_.begin(), obstacles_by_x_.end(), x_min,
                                   [&](std::uint32_t i, double x) { return points_[i][0] < x; });
  for (; obstacle != obstacles_by_x_.end() && points_[*obstacle][0] <= x_max; ++obstacle) {
    if (!obstacle_[*obstacle]) continue;
    const Point& p = points_[*obstacle];
    // Corners on the same place are the two sides of a bridge to a hole.
    if (p == a || p == b || p == c) continue;
    if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
  }
  return true;
}

void PolygonTriangulator::clip(std::uint32_t corner, std::vector<Triangle>& triangles) {
  const std::uint32_t before = previous_[corner], after = next_[corner];
  triangles.push_back({before, corner, after});
  next_[before] = after;
  previous_[after] = before;
  obstacle_[corner] = 0;
  ++entries_[corner];
  --remaining_;
  some_corner_ = after;
  for (const std::uint32_t neighbor : {before, after}) {
    if (obstacle_[neighbor]) obstacle_[neighbor] = turnAt(neighbor) <= 0;
    queue_.push_back({neighbor, ++entries_[neighbor]});
  }
}

}  // namespace bakelight::formats
