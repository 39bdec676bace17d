#include "tools/atlas/flatten/untangling.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "tools/atlas/charts/stretch.h"
#include "tools/atlas/flatten/injectivity.h"

namespace bakelight::atlas {
namespace {

constexpr std::size_t kLargestShare = 100;  // of the triangles, inverse
constexpr int kSweeps = 20;
constexpr int kProjections = 100;
constexpr int kHalvings = 8;
// Edges from one that crosses to the other, along a border.
constexpr std::size_t kReach = 16;
constexpr std::size_t kMostCrossings = 64;
// Of notches and holes, where the surface's area is 1.
constexpr double kLeastWidth = 4.0 / (1 << 20);
// Edges of notches and vertices of holes that are filled with triangles.
constexpr std::size_t kLargestFan = 8;
constexpr int kRounds = 4;
constexpr int kRelaxedRings = 3;
// Of a triangle's height in space, that it is to have in the plane at least.
constexpr double kLeastHeight = 0.1;

bool isFlipped(const Triangle& t, const std::vector<Vec2>& plane) {
  return !(crossOf(plane[t[0]], plane[t[1]], plane[t[2]]) > 0);
}

// A triangle outside of the chart that is not there, or too narrow to survive rounding (survivesRounding).
bool isClosed(const Triangle& gap, const std::vector<Vec2>& plane) {
  double longest = 0;
  for (std::size_t k = 0; k < 3; ++k)
    longest = std::max(longest, (plane[gap[(k + 1) % 3]] - plane[gap[k]]).norm());
  return !(crossOf(plane[gap[0]], plane[gap[1]], plane[gap[2]]) > kLeastWidth * longest);
}

// Which corners of triangles lie at each vertex.
class Stars {
 public:
  Stars(std::size_t vertices, std::span<const Triangle> triangles) : first_(vertices + 1, 0) {
    for (const Triangle& t : triangles)
      for (const std::uint32_t v : t) ++first_[v + 1];
    for (std::size_t v = 0; v < vertices; ++v) first_[v + 1] += first_[v];
    corners_.resize(3 * triangles.size());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t i = 0; i < triangles.size(); ++i)
      for (std::uint32_t k = 0; k < 3; ++k) corners_[next[triangles[i][k]]++] = 3 * i + k;
  }

  // 3 · triangle + corner.
  std::span<const std::uint32_t> of(std::uint32_t vertex) const {
    return std::span(corners_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
  }

 private:
  std::vector<std::uint32_t> first_, corners_;
};

// Where a vertex may be, if the triangle of one of its corners is to have some of its height.
struct HalfPlane {
  Vec2 normal;  // inward, of unit length
  double least;

  double missing(const Vec2& x) const { return least - normal.dot(x); }
};

class Mending {
 public:
  // `gaps` are triangles outside of the chart that must be the right way round, too.
  Mending(const Chart& chart, std::vector<Vec2>& plane, std::span<const Triangle> gaps = {})
      : chart_(chart), plane_(plane), triangles_(chart.triangles), stars_(0, {}) {
    triangles_.insert(triangles_.end(), gaps.begin(), gaps.end());
    stars_ = Stars(chart.vertexCount(), triangles_);
  }

  // Sweeps until none of `flipped` and around them is, or in vain.
  void turnOver(std::vector<std::uint32_t> flipped) {
    std::vector<std::uint32_t> moved;
    for (int sweep = 0; sweep < kSweeps && !flipped.empty(); ++sweep) sweepOver(flipped, moved);
    makeSet(moved);
    if (flipped.empty()) relax(std::move(moved));
  }

  // From one vertex of a border on, half of the way to the middle of its neighbours each.
  void drawFlat(const std::vector<std::uint32_t>& loop, std::size_t from, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = (from + k) % loop.size();
      const std::uint32_t v = loop[i];
      const Vec2 &before = plane_[loop[(i + loop.size() - 1) % loop.size()]],
                 &after = plane_[loop[(i + 1) % loop.size()]];
      findHalfPlanes(v);
      Vec2 move = ((before + after) / 2 - plane_[v]) / 2;
      const auto isFree = [&](const HalfPlane& half_plane) {
        return half_plane.missing(plane_[v] + move) <= std::max(0.0, half_plane.missing(plane_[v]));
      };
      for (int halving = 0; halving < kHalvings; ++halving, move /= 2)
        if (std::all_of(half_planes_.begin(), half_planes_.end(), isFree)) {
          plane_[v] += move;
          break;
        }
    }
  }

 private:
  // Leaves those of `flipped` and around them that still are.
  void sweepOver(std::vector<std::uint32_t>& flipped, std::vector<std::uint32_t>& moved) {
    std::vector<std::uint32_t> vertices;
    for (const std::uint32_t i : flipped)
      vertices.insert(vertices.end(), triangles_[i].begin(), triangles_[i].end());
    makeSet(vertices);
    moved.insert(moved.end(), vertices.begin(), vertices.end());
    for (const std::uint32_t v : vertices)
      if (isAmidFlipped(v)) moveInside(v);
    flipped.clear();
    for (const std::uint32_t v : vertices)
      for (const std::uint32_t corner : stars_.of(v))
        if (isWrong(corner / 3)) flipped.push_back(corner / 3);
    makeSet(flipped);
  }

  static void makeSet(std::vector<std::uint32_t>& values) {
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
  }

  bool isWrong(std::uint32_t triangle) const {
    return triangle < chart_.triangles.size() ? isFlipped(triangles_[triangle], plane_)
                                              : isClosed(triangles_[triangle], plane_);
  }

  bool isAmidFlipped(std::uint32_t v) const {
    const auto corners = stars_.of(v);
    return std::any_of(corners.begin(), corners.end(),
                       [&](std::uint32_t corner) { return isWrong(corner / 3); });
  }

  void findHalfPlanes(std::uint32_t v) {
    half_planes_.clear();
    for (const std::uint32_t corner : stars_.of(v)) {
      const Triangle& t = triangles_[corner / 3];
      const std::uint32_t from = t[(corner + 1) % 3], to = t[(corner + 2) % 3];
      const Vec2 edge = plane_[to] - plane_[from];
      const double length = edge.norm();
      if (!(length > 0)) continue;
      const Vec3 in_space = chart_.positions[to] - chart_.positions[from],
                 across = chart_.positions[v] - chart_.positions[from];
      // Across a gap the surface may be folded: what is as wide in the plane as in space is wide enough.
      const double height = corner / 3 < chart_.triangles.size()
                                ? in_space.cross(across).norm() / in_space.norm()
                                : across.norm() / 2;
      const Vec2 normal(-edge.y() / length, edge.x() / length);
      half_planes_.push_back({normal, normal.dot(plane_[from]) + kLeastHeight * height});
    }
  }

  void moveInside(std::uint32_t v) {
    findHalfPlanes(v);
    Vec2 x = plane_[v];
    for (int projection = 0; projection < kProjections; ++projection) {
      bool is_inside = true;
      for (const HalfPlane& half_plane : half_planes_) {
        const double missing = half_plane.missing(x);
        if (missing <= 0) continue;
        is_inside = false;
        x += missing * half_plane.normal;
      }
      if (is_inside) break;
    }
    if (x.allFinite()) plane_[v] = x;
  }

  // What was squeezed shares it with what is around: steps downhill of one vertex after the other.
  void relax(std::vector<std::uint32_t> vertices) {
    for (int ring = 0; ring < kRelaxedRings; ++ring) {
      const std::size_t inner = vertices.size();
      for (std::size_t i = 0; i < inner; ++i)
        for (const std::uint32_t corner : stars_.of(vertices[i]))
          vertices.insert(vertices.end(), triangles_[corner / 3].begin(), triangles_[corner / 3].end());
      makeSet(vertices);
    }
    for (int sweep = 0; sweep < kSweeps; ++sweep)
      for (const std::uint32_t v : vertices) moveDownhill(v);
  }

  // Twice the symmetric Dirichlet energy of the triangles at a vertex; infinite if one or a gap there is
  // flipped. The squares of the inverse of a map in the plane are its own over its determinant squared.
  double energyAround(std::uint32_t v) const {
    double energy = 0;
    for (const std::uint32_t corner : stars_.of(v)) {
      const Triangle& t = triangles_[corner / 3];
      if (isWrong(corner / 3)) return std::numeric_limits<double>::infinity();
      if (corner / 3 >= chart_.triangles.size()) continue;
      const double twice_area = crossOf(plane_[t[0]], plane_[t[1]], plane_[t[2]]);
      const Vec3 ab = chart_.positions[t[1]] - chart_.positions[t[0]],
                 ac = chart_.positions[t[2]] - chart_.positions[t[0]];
      const Vec2 flat_ab = plane_[t[1]] - plane_[t[0]], flat_ac = plane_[t[2]] - plane_[t[0]];
      const double rest = ab.cross(ac).norm();
      const double squares =
          (flat_ab.squaredNorm() * ac.squaredNorm() + flat_ac.squaredNorm() * ab.squaredNorm() -
           2 * flat_ab.dot(flat_ac) * ab.dot(ac)) /
          (rest * rest);
      const double determinant = twice_area / rest;
      energy += rest * squares * (1 + 1 / (determinant * determinant));
    }
    return energy;
  }

  // Differences are good enough where any step downhill will do.
  void moveDownhill(std::uint32_t v) {
    const Vec2 here = plane_[v];
    const double energy = energyAround(v);
    if (!std::isfinite(energy)) return;
    double reach = std::numeric_limits<double>::infinity();
    for (const std::uint32_t corner : stars_.of(v)) {
      const Triangle& t = triangles_[corner / 3];
      const Vec2 edge = plane_[t[(corner + 2) % 3]] - plane_[t[(corner + 1) % 3]];
      reach = std::min(reach, crossOf(plane_[t[0]], plane_[t[1]], plane_[t[2]]) / edge.norm());
    }
    const double h = 1e-3 * reach;
    const auto at = [&](double x, double y) {
      plane_[v] = here + Vec2(x, y);
      return energyAround(v);
    };
    const double right = at(h, 0), left = at(-h, 0), up = at(0, h), down = at(0, -h), diagonal = at(h, h);
    plane_[v] = here;
    const Vec2 gradient((right - left) / (2 * h), (up - down) / (2 * h));
    Eigen::Matrix2d hessian;
    hessian(0, 0) = (right - 2 * energy + left) / (h * h);
    hessian(1, 1) = (up - 2 * energy + down) / (h * h);
    hessian(0, 1) = hessian(1, 0) = (diagonal - right - up + energy) / (h * h);
    Vec2 step = -gradient;
    if (hessian.determinant() > 0 && hessian(0, 0) > 0)
      step = -hessian.inverse() * gradient;
    else
      step *= reach / std::max(gradient.norm(), std::numeric_limits<double>::min());
    if (!step.allFinite()) return;
    for (int halving = 0; halving < kHalvings; ++halving, step /= 2) {
      plane_[v] = here + step;
      if (energyAround(v) < energy) return;
    }
    plane_[v] = here;
  }

  const Chart& chart_;
  std::vector<Vec2>& plane_;
  std::vector<Triangle> triangles_;
  Stars stars_;
  std::vector<HalfPlane> half_planes_;
};

// A stretch of a border between two edges of it, by the shorter way.
struct Notch {
  std::size_t loop, from, edges;  // from the first vertex of the first edge
};

// Nothing if they are of different borders.
std::optional<Notch> notchOf(const Chart& chart, const BorderCrossing& crossing) {
  if (crossing.a.loop != crossing.b.loop) return std::nullopt;
  const std::size_t length = chart.borders[crossing.a.loop].size();
  std::size_t from = crossing.a.index, to = crossing.b.index;
  if ((to + length - from) % length > length / 2) std::swap(from, to);
  return Notch{crossing.a.loop, from, (to + length - from) % length + 1};
}

// Nothing if there are many, or one that is no notch.
std::optional<std::vector<Notch>> notchesOf(const Chart& chart, const std::vector<Vec2>& plane) {
  const std::vector<BorderCrossing> crossings = borderCrossings(chart, plane, kMostCrossings);
  if (crossings.size() == kMostCrossings) return std::nullopt;
  std::vector<Notch> notches;
  for (const BorderCrossing& crossing : crossings) {
    const auto notch = notchOf(chart, crossing);
    if (!notch || notch->edges > kReach) return std::nullopt;
    notches.push_back(*notch);
  }
  return notches;
}

bool drawCrossingsFlat(const Chart& chart, std::vector<Vec2>& plane) {
  std::optional<Mending> mending;
  for (int sweep = 0; sweep <= kSweeps; ++sweep) {
    const auto notches = notchesOf(chart, plane);
    if (!notches) return false;
    if (notches->empty()) return bordersTurnRight(chart, plane);
    if (!mending) mending.emplace(chart, plane);
    for (const Notch& notch : *notches)
      mending->drawFlat(chart.borders[notch.loop], notch.from, notch.edges + 1);
  }
  return false;
}

// The triangles of a fan outside of the chart, along its border.
void addFan(const std::vector<std::uint32_t>& loop, std::size_t from, std::size_t vertices,
            std::vector<Triangle>& gaps) {
  const auto at = [&](std::size_t k) { return loop[(from + k) % loop.size()]; };
  for (std::size_t k = 1; k + 1 < vertices; ++k) gaps.push_back({at(0), at(k + 1), at(k)});
}

// Makes triangles of what lies between the edges of notches, and in small holes, and turns those over.
bool spreadGaps(const Chart& chart, std::vector<Vec2>& plane) {
  std::vector<Triangle> gaps;
  for (int round = 0; round < kRounds; ++round) {
    const auto notches = notchesOf(chart, plane);
    if (!notches) return false;
    for (const Notch& notch : *notches) {
      if (notch.edges > kLargestFan) return false;
      addFan(chart.borders[notch.loop], notch.from, notch.edges + 1, gaps);
    }
    if (round == 0)
      for (std::size_t l = 1; l < chart.borders.size(); ++l)
        if (chart.borders[l].size() <= kLargestFan)
          addFan(chart.borders[l], 0, chart.borders[l].size(), gaps);
    std::vector<std::uint32_t> flipped;
    for (std::uint32_t i = 0; i < gaps.size(); ++i)
      if (isClosed(gaps[i], plane)) flipped.push_back(static_cast<std::uint32_t>(chart.triangles.size()) + i);
    if (flipped.empty()) break;
    Mending(chart, plane, gaps).turnOver(flipped);
  }
  return isInjective(chart, plane);
}

}  // namespace

bool hasFlipped(const Chart& chart, const std::vector<Vec2>& plane) {
  return std::any_of(chart.triangles.begin(), chart.triangles.end(),
                     [&](const Triangle& t) { return isFlipped(t, plane); });
}

bool untangle(const Chart& chart, std::vector<Vec2>& plane) {
  std::vector<std::uint32_t> flipped;
  for (std::uint32_t i = 0; i < chart.triangles.size(); ++i)
    if (isFlipped(chart.triangles[i], plane)) flipped.push_back(i);
  if (flipped.empty()) return true;
  if (flipped.size() > 1 + chart.triangles.size() / kLargestShare) return false;
  Mending(chart, plane).turnOver(flipped);
  return !hasFlipped(chart, plane);
}

bool uncrossBorders(const Chart& chart, std::vector<Vec2>& plane) {
  if (!bordersCross(chart, plane) && bordersTurnRight(chart, plane) && survivesRounding(chart, plane))
    return true;
  const std::vector<Vec2> before = plane;
  for (const bool first_flat : {true, false}) {
    const bool is_mended = (first_flat && drawCrossingsFlat(chart, plane)) || spreadGaps(chart, plane);
    if (is_mended && survivesRounding(chart, plane)) return true;
    plane = before;
  }
  return false;
}

}  // namespace bakelight::atlas
