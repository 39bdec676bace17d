#include "tools/mesomesh/retile/remesher.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <queue>
#include <utility>

#include "surface/collapse.h"
#include "tools/mesomesh/retile/sliding.h"

namespace bakelight::mesomesh {
namespace {

constexpr double kLongest = 4.0 / 3, kShortest = 4.0 / 5;
// Triangles that an operation replaces may turn by this much.
const double kTurnCosine = std::cos(50 * std::numbers::pi / 180);
// A flip that changes no valence must gain this much in the sum of the two angles opposite the edge.
constexpr double kAngleGain = 0.05;

double cosine(const Vec3& a, const Vec3& b) {
  const double lengths = a.norm() * b.norm();
  return lengths > 0 ? a.dot(b) / lengths : -1.0;
}

double angleAt(const Vec3& at, const Vec3& a, const Vec3& b) {
  return std::atan2((a - at).cross(b - at).norm(), (a - at).dot(b - at));
}

// The longest first: next to a longer edge, halves of a shorter one would make slivers without end.
void splitLong(SlidingMesh& sliding, double max_length, std::size_t max_vertices) {
  CornerMesh& mesh = sliding.mesh;
  std::priority_queue<std::pair<double, Side>> longest;
  const auto add = [&](Side s) {
    const double length = mesh.length(s);
    if (length > max_length) longest.push({length, s});
  };
  for (Side s = 0; s < mesh.opposite.size(); ++s)
    if (mesh.isEdge(s)) add(s);
  while (!longest.empty() && mesh.positions.size() < max_vertices) {
    const auto [length, s] = longest.top();
    longest.pop();
    if (mesh.length(s) != length) continue;  // another edge is there by now; it has its own entry
    const std::uint32_t a = mesh.start(s), b = mesh.end(s);
    const Side other = mesh.opposite[s];
    const auto first_added = static_cast<Side>(mesh.opposite.size());
    const bool on_curve = mesh.side_feature[s] != 0;
    const std::uint32_t like = sliding.isOnCurve(a) ? a : b;
    sliding.curve.push_back(on_curve ? std::uint32_t{sliding.curve[like]} : kNone);
    sliding.segment.push_back(std::uint32_t{sliding.segment[like]});
    sliding.near.push_back(std::uint32_t{sliding.near[sliding.isOnCurve(a) || sliding.isCorner(a) ? b : a]});
    mesh.splitEdge(s, (mesh.positions[a] + mesh.positions[b]) / 2);
    add(s);
    add(nextSide(s));
    if (other != kNone) add(nextSide(other));
    for (Side added = first_added; added < mesh.opposite.size(); ++added) add(added);
  }
}

class ShortEdges {
 public:
  ShortEdges(SlidingMesh& sliding, double edge_length)
      : sliding_(sliding), mesh_(sliding.mesh), collapses_(sliding.mesh), length_(edge_length) {}

  void collapseAll() {
    for (std::uint32_t v = 0; v < mesh_.positions.size(); ++v) {
      if (mesh_.leaving[v] == kNone || sliding_.isCorner(v)) continue;
      const std::uint32_t onto = find(v);
      if (onto != kNone) collapses_.apply(v, onto, work_);
    }
  }

 private:
  // The nearest neighbour that the vertex may be drawn onto.
  std::uint32_t find(std::uint32_t v) {
    const double shortest = kShortest * length_;
    candidates_.clear();
    curve_neighbors_.clear();
    const auto meet = [&](std::uint32_t to, Side s) {
      if (mesh_.side_feature[s] != 0) curve_neighbors_.push_back(to);
      if (sliding_.isOnCurve(v) && mesh_.side_feature[s] == 0) return;
      const double length = (mesh_.positions[to] - mesh_.positions[v]).norm();
      if (length < shortest) candidates_.push_back({length, to});
    };
    mesh_.forSidesAround(v, [&](Side s) {
      meet(mesh_.end(s), s);
      const Side in = previousSide(s);
      if (mesh_.opposite[in] == kNone) meet(mesh_.start(in), in);
    });
    std::sort(candidates_.begin(), candidates_.end());
    for (const auto& [length, to] : candidates_)
      if (keepsCurve(v, to) && keepsShape(v, to) && collapses_.keepsTopology(v, to, work_)) return to;
    return kNone;
  }

  bool keepsCurve(std::uint32_t v, std::uint32_t onto) const {
    if (!sliding_.isOnCurve(v)) return true;
    if (curve_neighbors_.size() != 2) return false;
    const std::uint32_t other = curve_neighbors_[curve_neighbors_[0] == onto ? 1 : 0];
    if (other == onto || (sliding_.isCorner(other) && sliding_.isCorner(onto))) return false;
    return !mesh_.areNeighbors(other, onto);  // three of a closed curve stay
  }

  bool keepsShape(std::uint32_t v, std::uint32_t onto) const {
    const Vec3 &from = mesh_.positions[v], &to = mesh_.positions[onto];
    bool ok = true;
    mesh_.forSidesAround(v, [&](Side s) {
      const std::uint32_t a = mesh_.end(s), b = mesh_.apex(s);
      if (!ok || a == onto || b == onto) return;
      const Vec3 &pa = mesh_.positions[a], &pb = mesh_.positions[b];
      const Vec3 before = (pa - from).cross(pb - from), after = (pa - to).cross(pb - to);
      const double longest = kLongest * length_;
      ok = after.squaredNorm() > 0 && (cosine(before, after) > kTurnCosine || !(before.squaredNorm() > 0)) &&
           (pa - to).norm() < longest && (pb - to).norm() < longest;
    });
    return ok;
  }

  SlidingMesh& sliding_;
  CornerMesh& mesh_;
  surface::Collapses collapses_;
  surface::Collapses::Workspace work_;
  double length_;
  std::vector<std::pair<double, std::uint32_t>> candidates_;
  std::vector<std::uint32_t> curve_neighbors_;
};

class Flips {
 public:
  explicit Flips(SlidingMesh& sliding) : mesh_(sliding.mesh), excess_(sliding.mesh.positions.size(), 0) {
    tbb::parallel_for(std::size_t{0}, mesh_.positions.size(), [&](std::size_t i) {
      const auto v = static_cast<std::uint32_t>(i);
      if (mesh_.leaving[v] == kNone) return;
      int sides = 0;
      double angle = 0;
      mesh_.forSidesAround(v, [&](Side s) {
        ++sides;
        angle += angleAt(mesh_.positions[v], mesh_.positions[mesh_.end(s)], mesh_.positions[mesh_.apex(s)]);
      });
      // As many triangles as equilateral ones fit around.
      const int best = mesh_.feature[v] == 0
                           ? 6
                           : std::max(1, static_cast<int>(std::lround(angle * 3 / std::numbers::pi)));
      excess_[v] = sides - best;
    });
  }

  void run() {
    for (Side s = 0; s < mesh_.opposite.size(); ++s) {
      if (!mesh_.isEdge(s) || mesh_.opposite[s] == kNone || mesh_.side_feature[s] != 0) continue;
      if (isWanted(s) && isAllowed(s)) flip(s);
    }
  }

 private:
  bool isWanted(Side s) const {
    const std::uint32_t a = mesh_.start(s), b = mesh_.end(s), c = mesh_.apex(s),
                        d = mesh_.apex(mesh_.opposite[s]);
    // (e − 1)² − e² = 1 − 2e, (e + 1)² − e² = 1 + 2e
    const int change = 4 - 2 * excess_[a] - 2 * excess_[b] + 2 * excess_[c] + 2 * excess_[d];
    if (change != 0) return change < 0;
    const Vec3 &pa = mesh_.positions[a], &pb = mesh_.positions[b], &pc = mesh_.positions[c],
               &pd = mesh_.positions[d];
    return angleAt(pc, pa, pb) + angleAt(pd, pa, pb) > angleAt(pa, pc, pd) + angleAt(pb, pc, pd) + kAngleGain;
  }

  bool isAllowed(Side s) const {
    const std::uint32_t a = mesh_.start(s), b = mesh_.end(s), c = mesh_.apex(s),
                        d = mesh_.apex(mesh_.opposite[s]);
    if (c == d || mesh_.areNeighbors(c, d)) return false;
    const Vec3 &pa = mesh_.positions[a], &pb = mesh_.positions[b], &pc = mesh_.positions[c],
               &pd = mesh_.positions[d];
    const Vec3 old = mesh_.areaVector(s / 3) + mesh_.areaVector(mesh_.opposite[s] / 3);
    const Vec3 one = (pa - pc).cross(pd - pc), two = (pb - pd).cross(pc - pd);
    return cosine(one, old) > kTurnCosine && cosine(two, old) > kTurnCosine;
  }

  void flip(Side s) {
    --excess_[mesh_.start(s)], --excess_[mesh_.end(s)];
    ++excess_[mesh_.apex(s)], ++excess_[mesh_.apex(mesh_.opposite[s])];
    mesh_.flip(s);
  }

  CornerMesh& mesh_;
  std::vector<int> excess_;  // triangles of each vertex beyond what is best
};

// Bits of 21-bit integers spread to every third.
std::uint64_t spread(std::uint64_t x) {
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

std::vector<std::uint32_t> spatialOrder(const CornerMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    if (mesh.leaving[v] != kNone) box.extend(mesh.positions[v]);
  const double scale = 2097151 / std::max(box.sizes().maxCoeff(), 1e-300);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!mesh.alive(t)) continue;
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3 middle = ((mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) / 3 - box.min()) * scale;
    std::uint64_t key = 0;
    for (int k = 0; k < 3; ++k)
      key |= spread(static_cast<std::uint64_t>(std::clamp(middle[k], 0.0, 2097151.0))) << k;
    keys.push_back({key, t});
  }
  tbb::parallel_sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> order(keys.size());
  std::transform(keys.begin(), keys.end(), order.begin(), [](const auto& key) { return key.second; });
  return order;
}

}  // namespace

void remeshOnce(SlidingMesh& mesh, const OriginalSurface& original, double edge_length,
                std::size_t max_vertices) {
  splitLong(mesh, kLongest * edge_length, max_vertices);
  ShortEdges(mesh, edge_length).collapseAll();
  Flips(mesh).run();
  evenOut(mesh, original, 1);
}

void polish(SlidingMesh& mesh, const OriginalSurface& original, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    Flips(mesh).run();
    evenOut(mesh, original, 1);
  }
}

SlidingMesh compacted(const SlidingMesh& sliding) {
  const CornerMesh& from = sliding.mesh;
  const std::vector<std::uint32_t> order = spatialOrder(from);
  std::vector<std::uint32_t> new_vertex(from.positions.size(), kNone);
  transport::SurfaceMesh surface;
  SlidingMesh result{CornerMesh(surface), {}, {}, {}};
  std::vector<std::uint8_t> feature, locked;
  for (const std::uint32_t t : order) {
    formats::Triangle triangle;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = from.triangles[t][k];
      if (new_vertex[v] == kNone) {
        new_vertex[v] = static_cast<std::uint32_t>(surface.positions.size());
        surface.positions.push_back(Vec3(from.positions[v]));
        result.curve.push_back(std::uint32_t{sliding.curve[v]});
        result.near.push_back(std::uint32_t{sliding.near[v]});
        result.segment.push_back(std::uint32_t{sliding.segment[v]});
        feature.push_back(std::uint8_t{from.feature[v]});
        locked.push_back(std::uint8_t{from.locked[v]});
      }
      triangle[k] = new_vertex[v];
    }
    surface.triangles.push_back(triangle);
    surface.materials.push_back(std::uint32_t{from.materials[t]});
  }
  result.mesh = CornerMesh(surface);
  result.mesh.feature = std::move(feature), result.mesh.locked = std::move(locked);
  for (std::size_t t = 0; t < order.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      result.mesh.side_feature[3 * t + k] = from.side_feature[3 * std::size_t{order[t]} + k];
  return result;
}

}  // namespace bakelight::mesomesh
