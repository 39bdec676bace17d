#include "tools/atlas/flatten/guided_start.h"

#include <algorithm>
#include <map>
#include <utility>

#include "tools/atlas/charts/stretch.h"
#include "tools/atlas/flatten/distortion_energy.h"
#include "tools/atlas/flatten/pair_laplacian.h"
#include "tools/atlas/flatten/untangling.h"

namespace bakelight::atlas {
namespace {

// Local and global phases at most, the first being the guides'.
constexpr int kRounds = 4;

Vec2 product(const Vec2& a, const Vec2& b) {
  return {a.x() * b.x() - a.y() * b.y(), a.x() * b.y() + a.y() * b.x()};
}
Vec2 conjugate(const Vec2& a) {
  return {a.x(), -a.y()};
}
// Of unit length, or along x.
Vec2 directionOf(const Vec2& a) {
  const double length = a.norm();
  return length > 0 ? Vec2(a / length) : Vec2(1, 0);
}

// The first column of the rotation that is nearest to the map with these images of the corners.
Vec2 nearestRotation(const RestTriangle& rest, const Triangle& t, std::span<const Vec2> plane) {
  Vec2 sum = Vec2::Zero();
  for (std::size_t k = 0; k < 3; ++k) sum += product(plane[t[k]], conjugate(rest.gradients[k]));
  return directionOf(sum);
}

// Edge k of a triangle in the plane where edge 0 runs along x, as long as it is.
Vec2 restEdge(const Surface& surface, std::uint32_t triangle, std::size_t k) {
  const Vec3 x = (surface.corner(triangle, 1) - surface.corner(triangle, 0)).normalized();
  const Vec3 y = surface.normals[triangle].cross(x);
  const Vec3 edge = surface.corner(triangle, (k + 1) % 3) - surface.corner(triangle, k);
  return {x.dot(edge), y.dot(edge)};
}

// Turns planes onto each other along the edges between them, from the one with most triangles on; the one
// with the longest edges to those that are there comes next.
class Alignment {
 public:
  Alignment(const Surface& surface, const Chart& chart, const Guides& guides) {
    const auto& triangles = chart.surface_triangles;
    for (const std::uint32_t t : triangles) ++sizes_[guides.planes[t]];
    if (sizes_.size() > 1)
      for (const std::uint32_t t : triangles) addEdges(surface, triangles, t, guides);
    join();
  }

  const Vec2& turnOf(std::int32_t plane) const { return turns_.at(plane); }

 private:
  using Pair = std::pair<std::int32_t, std::int32_t>;

  void addEdges(const Surface& surface, const std::vector<std::uint32_t>& triangles, std::uint32_t t,
                const Guides& guides) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t next = surface.passable(t, k);
      if (next < 0 || guides.planes[next] == guides.planes[t]) continue;
      const auto other = static_cast<std::uint32_t>(next);
      if (!std::binary_search(triangles.begin(), triangles.end(), other)) continue;
      std::size_t back = 0;
      while (surface.triangles[other][back] != surface.triangles[t][(k + 1) % 3]) ++back;
      const Vec2 mine = product(guides.directions[t], restEdge(surface, t, k)),
                 theirs = -product(guides.directions[other], restEdge(surface, other, back));
      const double length = mine.norm();
      if (!(length > 0)) continue;
      const Pair pair{guides.planes[t], guides.planes[other]};
      between_.try_emplace(pair, Vec2::Zero()).first->second += product(mine, conjugate(theirs)) / length;
    }
  }

  void join() {
    const auto first = std::max_element(sizes_.begin(), sizes_.end(),
                                        [](const auto& a, const auto& b) { return a.second < b.second; });
    turns_[first->first] = {1, 0};
    while (turns_.size() < sizes_.size()) {
      std::map<std::int32_t, Vec2> sums;
      for (const auto& [pair, turn] : between_)
        if (turns_.contains(pair.first) && !turns_.contains(pair.second)) {
          const auto entry = sums.try_emplace(pair.second, Vec2::Zero()).first;
          entry->second += product(turns_.at(pair.first), turn);
        }
      if (sums.empty()) break;
      const auto next = std::max_element(sums.begin(), sums.end(), [](const auto& a, const auto& b) {
        return a.second.squaredNorm() < b.second.squaredNorm();
      });
      turns_[next->first] = directionOf(next->second);
    }
    for (const auto& [plane, size] : sizes_) turns_.try_emplace(plane, 1, 0);
  }

  std::map<std::int32_t, std::size_t> sizes_;  // triangles
  std::map<Pair, Vec2> between_;               // of the second plane onto the first, weighted by length
  std::map<std::int32_t, Vec2> turns_;
};

// min Σ area · |J − R|² for rotations R given.
class NearestPlane {
 public:
  explicit NearestPlane(const Chart& chart) : chart_(chart), rest_(restTriangles(chart)) {
    laplacian_.setPattern(chart.vertexCount(), chart.triangles);
    laplacian_.begin();
    for (std::size_t i = 0; i < rest_.size(); ++i) {
      const auto& g = rest_[i].gradients;
      const double area = rest_[i].area;
      laplacian_.add(i, {area * g[0].dot(g[0]), area * g[1].dot(g[0]), area * g[1].dot(g[1]),
                         area * g[2].dot(g[0]), area * g[2].dot(g[1]), area * g[2].dot(g[2])});
    }
    is_solvable_ = laplacian_.factorize();
  }

  const std::vector<RestTriangle>& rest() const { return rest_; }

  bool solve(std::span<const Vec2> directions, std::vector<Vec2>& plane) {
    if (!is_solvable_) return false;
    const auto unknowns = static_cast<Eigen::Index>(2 * chart_.vertexCount());
    Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns), solution(unknowns);
    for (std::size_t i = 0; i < rest_.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec2 pull = rest_[i].area * product(directions[i], rest_[i].gradients[k]);
        right.segment<2>(2 * static_cast<Eigen::Index>(chart_.triangles[i][k])) += pull;
      }
    laplacian_.solve(right, solution);
    plane.resize(chart_.vertexCount());
    for (std::size_t v = 0; v < plane.size(); ++v)
      plane[v] = solution.segment<2>(static_cast<Eigen::Index>(2 * v));
    return solution.allFinite();
  }

 private:
  const Chart& chart_;
  std::vector<RestTriangle> rest_;
  PairLaplacian laplacian_;
  bool is_solvable_ = false;
};

}  // namespace

void Guides::set(std::span<const std::uint32_t> triangles, std::span<const Vec2> triangle_directions,
                 std::int32_t plane) {
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    directions[triangles[i]] = triangle_directions[i];
    planes[triangles[i]] = plane;
  }
}

std::vector<Vec2> directionsIn(const Chart& chart, std::span<const Vec2> plane) {
  const std::vector<RestTriangle> rest = restTriangles(chart);
  std::vector<Vec2> directions(rest.size());
  for (std::size_t i = 0; i < rest.size(); ++i)
    directions[i] = nearestRotation(rest[i], chart.triangles[i], plane);
  return directions;
}

Vec2 directionBeside(const Surface& surface, std::uint32_t triangle, const Surface& other_surface,
                     std::uint32_t other, const Vec2& direction_of_other) {
  const Vec3& normal = surface.normals[triangle];
  const Vec3& other_normal = other_surface.normals[other];
  const Vec3 edge = (surface.corner(triangle, 1) - surface.corner(triangle, 0)).normalized();
  // The shortest turn that takes one normal to the other; any will do for opposite ones.
  const double cosine = normal.dot(other_normal);
  Vec3 turned = edge;
  if (cosine > -1 + 1e-6) {
    const Vec3 axis = normal.cross(other_normal);
    turned = cosine * edge + axis.cross(edge) + axis * (axis.dot(edge) / (1 + cosine));
  }
  const Vec3 x = (other_surface.corner(other, 1) - other_surface.corner(other, 0)).normalized();
  const Vec3 y = other_normal.cross(x);
  return directionOf(product(direction_of_other, {x.dot(turned), y.dot(turned)}));
}

std::optional<std::vector<Vec2>> guidedStart(const Surface& surface, const Chart& chart,
                                             const Guides& guides) {
  const auto& triangles = chart.surface_triangles;
  if (guides.empty() ||
      std::any_of(triangles.begin(), triangles.end(), [&](std::uint32_t t) { return guides.planes[t] < 0; }))
    return std::nullopt;
  const Alignment alignment(surface, chart, guides);
  std::vector<Vec2> directions;
  directions.reserve(triangles.size());
  for (const std::uint32_t t : triangles)
    directions.push_back(product(alignment.turnOf(guides.planes[t]), guides.directions[t]));
  NearestPlane nearest(chart);
  std::vector<Vec2> plane;
  for (int round = 0; round < kRounds; ++round) {
    if (!nearest.solve(directions, plane)) return std::nullopt;
    if (!hasFlipped(chart, plane)) return plane;
    for (std::size_t i = 0; i < directions.size(); ++i)
      directions[i] = nearestRotation(nearest.rest()[i], chart.triangles[i], plane);
  }
  if (untangle(chart, plane)) return plane;
  return std::nullopt;
}

}  // namespace bakelight::atlas
