#include "tools/atlas/charts/proxy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <tuple>

namespace bakelight::atlas {
namespace {

constexpr std::uint32_t kNone = ~0u;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Of the squared distance to the vertex itself, beside that to the planes around it: keeps triangles of flat
// parts in shape.
constexpr double kRoundness = 1e-3;
// Cosine between a triangle's normals before and after a collapse.
constexpr double kLeastCosine = 0.3;
// Vertices with more triangles stay.
constexpr std::size_t kLargestFan = 64;

// Σ weight · (distance to a plane or a point)², as xᵀAx + 2b·x + c.
struct Quadric {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Vec3 b = Vec3::Zero();
  double c = 0;

  void addPlane(const Vec3& normal, const Vec3& point, double weight) {
    const double offset = normal.dot(point);
    a += weight * normal * normal.transpose();
    b -= weight * offset * normal;
    c += weight * offset * offset;
  }
  void addPoint(const Vec3& point, double weight) {
    a.diagonal().array() += weight;
    b -= weight * point;
    c += weight * point.squaredNorm();
  }
  void add(const Quadric& other) { a += other.a, b += other.b, c += other.c; }
  double at(const Vec3& x) const { return x.dot(a * x) + 2 * b.dot(x) + c; }
};

class Decimation {
 public:
  explicit Decimation(const Surface& surface)
      : surface_(surface),
        triangles_(surface.triangles),
        is_alive_(surface.triangleCount(), 1),
        alive_(surface.triangleCount()),
        first_(surface.positions.size(), kNone),
        last_(surface.positions.size(), kNone),
        next_(3 * surface.triangleCount(), kNone),
        stays_(surface.positions.size(), 0),
        marks_(surface.positions.size(), 0),
        quadrics_(surface.positions.size()) {
    for (std::uint32_t corner = 0; corner < next_.size(); ++corner) append(vertexAt(corner), corner);
    for (std::uint32_t t = 0; t < triangles_.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        Quadric& quadric = quadrics_[triangles_[t][k]];
        quadric.addPlane(surface.normals[t], surface.corner(t, k), surface.areas[t] / 3);
        quadric.addPoint(surface.corner(t, k), kRoundness * surface.areas[t] / 3);
      }
    findFixedVertices();
  }

  void run(std::size_t target) {
    using Entry = std::tuple<double, std::uint32_t>;
    std::vector<Entry> first;
    for (std::uint32_t v = 0; v < stays_.size(); ++v)
      if (!stays_[v] && first_[v] != kNone)
        if (const Collapse best = bestOf(v); best.into != kNone) first.emplace_back(best.cost, v);
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue(std::greater<>(), std::move(first));
    while (alive_ > target && !queue.empty()) {
      const auto [cost, v] = queue.top();
      queue.pop();
      if (first_[v] == kNone) continue;
      // Costs grow while a vertex waits: one that has grown waits again.
      const Collapse best = bestOf(v);
      if (best.into == kNone) continue;
      if (best.cost > cost && !queue.empty() && best.cost > std::get<0>(queue.top())) {
        queue.emplace(best.cost, v);
        continue;
      }
      collapse(v, best.into);
    }
  }

  const std::vector<Triangle>& triangles() const { return triangles_; }
  bool isAlive(std::size_t triangle) const { return is_alive_[triangle] != 0; }

 private:
  struct Collapse {
    double cost = kInfinity;
    std::uint32_t into = kNone;
  };

  std::uint32_t vertexAt(std::uint32_t corner) const { return triangles_[corner / 3][corner % 3]; }
  void append(std::uint32_t v, std::uint32_t corner) {
    (first_[v] == kNone ? first_[v] : next_[last_[v]]) = corner;
    last_[v] = corner;
  }

  // The corners of living triangles at a vertex; those of dead ones leave its list.
  void cornersOf(std::uint32_t v, std::vector<std::uint32_t>& corners) {
    corners.clear();
    std::uint32_t* link = &first_[v];
    std::uint32_t last = kNone;
    for (std::uint32_t corner = first_[v]; corner != kNone; corner = next_[corner]) {
      if (!is_alive_[corner / 3]) {
        *link = next_[corner];
        continue;
      }
      corners.push_back(corner);
      last = corner;
      link = &next_[corner];
    }
    last_[v] = last;
  }

  // The ends of edges that two triangles do not share in the ordinary way, or that are marked; and vertices
  // whose triangles are not one fan.
  void findFixedVertices() {
    std::vector<std::uint32_t> fan;
    for (std::uint32_t t = 0; t < triangles_.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k)
        if (surface_.neighbors[t][k] < 0 || surface_.marks[t][k] != EdgeMark::kNone)
          stays_[triangles_[t][k]] = stays_[triangles_[t][(k + 1) % 3]] = 1;
    for (std::uint32_t v = 0; v < stays_.size(); ++v) {
      if (stays_[v] || first_[v] == kNone) continue;
      cornersOf(v, fan);
      // Around the vertex, across the edges that arrive at it.
      std::uint32_t corner = first_[v];
      std::size_t steps = 0;
      do {
        const std::int32_t other = surface_.neighbors[corner / 3][(corner % 3 + 2) % 3];
        const Triangle& triangle = triangles_[other];
        const std::uint32_t k = triangle[0] == v ? 0 : triangle[1] == v ? 1 : 2;
        corner = 3 * static_cast<std::uint32_t>(other) + k;
      } while (++steps <= fan.size() && corner != first_[v]);
      stays_[v] = steps != fan.size();
    }
  }

  Collapse bestOf(std::uint32_t v) {
    cornersOf(v, corners_);
    if (corners_.size() < 3 || corners_.size() > kLargestFan) return {};
    // Each neighbour follows the vertex in one triangle of its fan.
    targets_.clear();
    for (const std::uint32_t corner : corners_) {
      const std::uint32_t into = triangles_[corner / 3][(corner % 3 + 1) % 3];
      const Vec3& x = surface_.positions[into];
      targets_.push_back({quadrics_[v].at(x) + quadrics_[into].at(x), into});
    }
    std::sort(targets_.begin(), targets_.end(), [](const Collapse& a, const Collapse& b) {
      return std::tie(a.cost, a.into) < std::tie(b.cost, b.into);
    });
    for (const Collapse& target : targets_)
      if (keepsShape(v, target.into) && keepsTopology(v, target.into)) return target;
    return {};
  }

  bool keepsShape(std::uint32_t v, std::uint32_t into) const {
    const Vec3 &before = surface_.positions[v], &after = surface_.positions[into];
    return std::all_of(corners_.begin(), corners_.end(), [&](std::uint32_t corner) {
      const Triangle& t = triangles_[corner / 3];
      const std::uint32_t a = t[(corner % 3 + 1) % 3], b = t[(corner % 3 + 2) % 3];
      if (a == into || b == into) return true;
      const Vec3 &p = surface_.positions[a], &q = surface_.positions[b];
      const Vec3 old_normal = (p - before).cross(q - before), new_normal = (p - after).cross(q - after);
      return new_normal.dot(old_normal) >
             kLeastCosine * std::sqrt(new_normal.squaredNorm() * old_normal.squaredNorm());
    });
  }

  // The link condition: the two ends have no neighbours in common but those of the edge's two triangles; and
  // the fan that is left does not close on a triangle that is there.
  bool keepsTopology(std::uint32_t v, std::uint32_t into) {
    const std::uint32_t of_v = ++stamp_, of_both = ++stamp_;
    for (const std::uint32_t corner : corners_)
      for (const std::uint32_t w : triangles_[corner / 3]) marks_[w] = of_v;
    cornersOf(into, others_);
    std::size_t common = 0;
    for (const std::uint32_t corner : others_) {
      std::size_t around = 0;
      for (const std::uint32_t w : triangles_[corner / 3]) {
        if (w == v || w == into || marks_[w] < of_v) continue;
        ++around;
        if (marks_[w] == of_both) continue;
        marks_[w] = of_both;
        ++common;
      }
      if (around == 2 && corners_.size() == 3) return false;
    }
    return common == 2;
  }

  void collapse(std::uint32_t v, std::uint32_t into) {
    cornersOf(v, corners_);
    for (const std::uint32_t corner : corners_) {
      Triangle& t = triangles_[corner / 3];
      if (std::find(t.begin(), t.end(), into) != t.end()) {
        is_alive_[corner / 3] = 0;
        --alive_;
        continue;
      }
      t[corner % 3] = into;
      next_[corner] = kNone;
      append(into, corner);
    }
    first_[v] = last_[v] = kNone;
    quadrics_[into].add(quadrics_[v]);
  }

  const Surface& surface_;
  std::vector<Triangle> triangles_;
  std::vector<std::uint8_t> is_alive_;
  std::size_t alive_;
  std::vector<std::uint32_t> first_, last_, next_;  // lists of corners by vertex
  std::vector<std::uint8_t> stays_;
  std::vector<std::uint32_t> marks_;
  std::uint32_t stamp_ = 0;
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> corners_, others_;
  std::vector<Collapse> targets_;
};

// Marked edges keep their ends, so they are edges still.
void carryMarks(const Surface& from, std::span<const std::uint32_t> place_of, Surface& to) {
  struct Marked {
    std::uint32_t low, high;
    EdgeMark mark;
  };
  const auto key = [](const Marked& m) { return std::tuple(m.low, m.high); };
  std::vector<Marked> marked;
  for (std::size_t t = 0; t < from.triangleCount(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      if (from.marks[t][k] != EdgeMark::kNone) {
        const std::uint32_t a = place_of[from.triangles[t][k]], b = place_of[from.triangles[t][(k + 1) % 3]];
        marked.push_back({std::min(a, b), std::max(a, b), from.marks[t][k]});
      }
  std::sort(marked.begin(), marked.end(), [&](const Marked& a, const Marked& b) { return key(a) < key(b); });
  for (std::size_t t = 0; t < to.triangleCount(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = to.triangles[t][k], b = to.triangles[t][(k + 1) % 3];
      const Marked edge{std::min(a, b), std::max(a, b), EdgeMark::kNone};
      const auto it = std::lower_bound(marked.begin(), marked.end(), edge,
                                       [&](const Marked& x, const Marked& y) { return key(x) < key(y); });
      if (it != marked.end() && key(*it) == key(edge)) to.marks[t][k] = it->mark;
    }
}

}  // namespace

Proxy proxyOf(const Surface& surface, std::size_t triangles) {
  Decimation decimation(surface);
  decimation.run(triangles);
  Proxy proxy;
  Surface& result = proxy.surface;
  result.center = surface.center;
  result.scale = surface.scale;
  std::vector<std::uint32_t> place_of(surface.positions.size(), kNone);
  for (std::uint32_t t = 0; t < surface.triangleCount(); ++t) {
    if (!decimation.isAlive(t)) continue;
    Triangle places = decimation.triangles()[t];
    for (std::uint32_t& v : places) {
      if (place_of[v] == kNone) {
        place_of[v] = static_cast<std::uint32_t>(result.positions.size());
        result.positions.push_back(surface.positions[v]);
      }
      v = place_of[v];
    }
    const Vec3& a = result.positions[places[0]];
    const Vec3 doubled = (result.positions[places[1]] - a).cross(result.positions[places[2]] - a);
    const double length = doubled.norm();
    result.triangles.push_back(places);
    result.source_triangles.push_back(t);
    result.normals.push_back(length > 0 ? Vec3(doubled / length) : surface.normals[t]);
    result.areas.push_back(length / 2);
    result.area += length / 2;
  }
  findNeighbors(result);
  carryMarks(surface, place_of, result);
  return proxy;
}

std::vector<std::int32_t> nearestOfProxy(const Surface& surface, std::span<const std::int32_t> regions,
                                         const Proxy& proxy) {
  std::vector<std::int32_t> result(surface.triangleCount(), -1);
  std::vector<std::uint32_t> queue = proxy.surface.source_triangles;
  queue.reserve(surface.triangleCount());
  for (std::size_t i = 0; i < queue.size(); ++i) result[queue[i]] = static_cast<std::int32_t>(i);
  for (std::size_t i = 0; i < queue.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t other = surface.passable(queue[i], k);
      if (other < 0 || result[other] >= 0 || regions[other] != regions[queue[i]]) continue;
      result[other] = result[queue[i]];
      queue.push_back(static_cast<std::uint32_t>(other));
    }
  return result;
}

}  // namespace bakelight::atlas
