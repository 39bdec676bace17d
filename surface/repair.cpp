#include "surface/repair.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <span>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "surface/edge_groups.h"
#include "surface/inside_out.h"
#include "surface/needles.h"
#include "surface/parallel_lists.h"

namespace bakelight::surface {
namespace {

using Index = std::uint32_t;
using Corner = Side;

Index start(const WorkingMesh& mesh, Corner side) {
  return mesh.triangles[side / 3][side % 3];
}
Index end(const WorkingMesh& mesh, Corner side) {
  return start(mesh, nextSide(side));
}

// ---- weld
// -------------------------------------------------------------------------------------------------------

// Of each vertex the first one at exactly that place.
std::vector<Index> exactRepresentatives(const std::vector<Vec3>& positions) {
  std::vector<Index> order(positions.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](Index i) {
    return std::array<double, 3>{positions[i].x(), positions[i].y(), positions[i].z()};
  };
  tbb::parallel_sort(order.begin(), order.end(), [&](Index a, Index b) {
    const auto ka = key(a), kb = key(b);
    return ka < kb || (ka == kb && a < b);
  });
  std::vector<Index> representative(positions.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
    representative[order[i]] = same ? representative[order[i - 1]] : order[i];
  }
  return representative;
}

// Points sorted by the cells of a grid.
class PointGrid {
 public:
  // `reach` is no more than the size of a cell.
  PointGrid(const std::vector<Vec3>& positions, const std::vector<Index>& points, double reach)
      : cell_size_(kReaches * reach), reach_(reach), entries_(points.size()) {
    tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
      const Vec3& p = positions[points[i]];
      entries_[i] = {hash({cellOf(p.x()), cellOf(p.y()), cellOf(p.z())}), points[i]};
    });
    tbb::parallel_sort(entries_.begin(), entries_.end());
  }

  // Stops where `visit` returns true. Visits points of the cells that are within reach, and perhaps others.
  template <class Visit>
  void forNear(const Vec3& position, Visit visit) const {
    std::array<std::array<std::int64_t, 2>, 3> range{};
    for (int k = 0; k < 3; ++k) range[k] = {cellOf(position[k] - reach_), cellOf(position[k] + reach_)};
    for (std::int64_t x = range[0][0]; x <= range[0][1]; ++x) {
      for (std::int64_t y = range[1][0]; y <= range[1][1]; ++y) {
        for (std::int64_t z = range[2][0]; z <= range[2][1]; ++z) {
          const std::uint64_t cell = hash({x, y, z});
          for (auto it = std::lower_bound(entries_.begin(), entries_.end(), std::pair(cell, Index{0}));
               it != entries_.end() && it->first == cell; ++it) {
            if (visit(it->second)) return;
          }
        }
      }
    }
  }

 private:
  // Larger cells hold more points, smaller ones have more neighbours in reach.
  static constexpr double kReaches = 8;
  // Points so far out share a cell, which costs time only.
  static constexpr double kFarthestCell = 4e18;

  std::int64_t cellOf(double x) const {
    return static_cast<std::int64_t>(std::clamp(std::floor(x / cell_size_), -kFarthestCell, kFarthestCell));
  }
  static std::uint64_t hash(const std::array<std::int64_t, 3>& cell) {
    std::uint64_t h = 0x9E3779B97F4A7C15u;
    for (const std::int64_t x : cell)
      h = (h ^ static_cast<std::uint64_t>(x)) * 0xD6E8FEB86659FD93u, h ^= h >> 32;
    return h;
  }

  double cell_size_, reach_;
  std::vector<std::pair<std::uint64_t, Index>> entries_;
};

// Each vertex joins the first earlier representative within the tolerance. What coincides does so at once,
// and most of the rest is near no other: only what is left goes one by one.
std::vector<Index> nearRepresentatives(const std::vector<Vec3>& positions, double tolerance) {
  std::vector<Index> representative = exactRepresentatives(positions);
  const auto near = [&](Index a, Index b) { return (positions[a] - positions[b]).norm() <= tolerance; };
  const std::vector<Index> distinct =
      filtered(positions.size(), [&](std::size_t i) { return representative[i] == i; });
  const PointGrid grid(positions, distinct, tolerance);
  const std::vector<Index> crowded = filtered(distinct, [&](Index i) {
    bool found = false;
    grid.forNear(positions[i], [&](Index other) { return found = other != i && near(other, i); });
    return found;
  });
  for (const Index i : crowded) {
    grid.forNear(positions[i], [&](Index other) {
      if (other < representative[i] && representative[other] == other && near(other, i))
        representative[i] = other;
      return false;
    });
  }
  if (!crowded.empty()) {
    for (Index& r : representative) r = representative[r];
  }
  return representative;
}

void weld(WorkingMesh& mesh, double tolerance, RepairCounts& counts) {
  std::vector<bool> used(mesh.positions.size());
  for (const Triangle& t : mesh.triangles) {
    for (const Index i : t) used[i] = true;
  }
  const std::vector<Index> representative = weldedVertices(mesh.positions, tolerance);
  for (Index i = 0; i < representative.size(); ++i) {
    if (!used[i])
      ++counts.isolated_vertices;
    else if (representative[i] != i)
      ++counts.welded_vertices;
  }
  for (Triangle& t : mesh.triangles) {
    for (Index& i : t) i = representative[i];
  }
}

// ---- triangles that say nothing, or say it twice
// -------------------------------------------------------------------

void removeRepeatedIndices(WorkingMesh& mesh, RepairCounts& counts) {
  std::vector<bool> keep(mesh.triangles.size());
  for (std::size_t t = 0; t < keep.size(); ++t) {
    const auto [a, b, c] = mesh.triangles[t];
    keep[t] = a != b && b != c && c != a;
    counts.repeated_index_triangles += !keep[t];
  }
  keepTriangles(mesh, keep);
}

// The same triangle, turned so that its smallest index comes first: equal for equal orientation.
Triangle canonical(Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

// ---- orientation and manifoldness
// ----------------------------------------------------------------------------------

// Disjoint sets of corners; the smallest corner represents its set.
class CornerSets {
 public:
  explicit CornerSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  Corner find(Corner c) {
    while (parent_[c] != c) c = parent_[c] = parent_[parent_[c]];
    return c;
  }
  void join(Corner a, Corner b) {
    a = find(a), b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<Corner> parent_;
};

// ---- sheets of two sides
// -------------------------------------------------------------------------------------------

// Triangles that lie back to back on each other.
class OppositePairs {
 public:
  // `twin` of each triangle, or kNone. Triangles that are not kept are as good as gone.
  OppositePairs(const WorkingMesh& mesh, const std::vector<Index>& twin, const std::vector<bool>& keep)
      : twin_(twin), part_(twin.size()), is_front_(twin.size()) {
    const EdgeGroups edges(mesh);
    std::vector<std::size_t> group_of(3 * twin.size());
    std::vector<bool> attached(twin.size()), open(twin.size());
    CornerSets parts(twin.size());
    for (std::size_t g = 0; g < edges.count(); ++g) {
      Index first = kNone;
      std::size_t paired = 0, others = 0;
      for (const Corner side : edges.group(g)) {
        const Index t = side / 3;
        group_of[side] = g;
        if (!keep[t]) continue;
        ++(twin[t] == kNone ? others : paired);
        if (twin[t] == kNone) continue;
        if (first == kNone) first = t;
        parts.join(first, t);
      }
      if (first == kNone) continue;
      if (others > 0) attached[first] = true;
      if (paired == 2) open[first] = true;
    }
    std::vector<bool> part_attached(twin.size()), part_open(twin.size());
    for (Index t = 0; t < twin.size(); ++t) {
      part_[t] = parts.find(t);
      if (attached[t]) part_attached[part_[t]] = true;
      if (open[t]) part_open[part_[t]] = true;
    }
    is_sheet_.resize(twin.size());
    is_closed_.resize(twin.size());
    for (Index t = 0; t < twin.size(); ++t) {
      if (twin[t] == kNone || !keep[t]) continue;
      is_sheet_[t] = part_open[part_[t]] && !part_attached[part_[t]];
      is_closed_[t] = !part_open[part_[t]] && !part_attached[part_[t]];
    }
    chooseFronts(mesh, edges, group_of, keep);
  }

  // Of a part that is open and hangs together with no triangle that has no back.
  bool isSheet(Index t) const { return is_sheet_[t]; }
  bool isOfClosedPart(Index t) const { return is_closed_[t]; }
  // One of each two; those of a part face the same way.
  bool isFront(Index t) const { return is_front_[t]; }

 private:
  void chooseFronts(const WorkingMesh& mesh, const EdgeGroups& edges,
                    const std::vector<std::size_t>& group_of, const std::vector<bool>& keep) {
    std::vector<bool> seen(twin_.size());
    std::vector<Index> queue;
    const auto take = [&](Index front) {
      if (seen[front]) return;
      seen[front] = seen[twin_[front]] = true;
      is_front_[front] = true;
      queue.push_back(front);
    };
    for (Index seed = 0; seed < twin_.size(); ++seed) {
      if (twin_[seed] == kNone || !keep[seed] || seen[seed]) continue;
      queue.clear();
      take(seed);
      for (std::size_t next = 0; next < queue.size(); ++next) {
        for (Corner side = 3 * queue[next]; side < 3 * queue[next] + 3; ++side) {
          for (const Corner other : edges.group(group_of[side])) {
            if (twin_[other / 3] != kNone && keep[other / 3] && start(mesh, side) == end(mesh, other))
              take(other / 3);
          }
        }
      }
    }
  }

  const std::vector<Index>& twin_;
  std::vector<Index> part_;
  std::vector<bool> is_front_, is_sheet_, is_closed_;
};

// Of each two triangles back to back one goes; that of a whole sheet remembers what the other showed.
void settlePairs(WorkingMesh& mesh, const std::vector<Index>& twin, std::vector<bool>& keep,
                 RepairCounts& counts) {
  const OppositePairs pairs(mesh, twin, keep);
  std::map<std::pair<Index, Index>, Index> sheet_of;
  const auto materialOf = [&](Index t) { return mesh.materials.empty() ? 0 : mesh.materials[t]; };
  std::vector<std::pair<Index, Index>> fronts;  // triangle, sheet
  for (Index t = 0; t < twin.size(); ++t) {
    if (twin[t] == kNone || !keep[t] || !keep[twin[t]]) continue;
    if (!pairs.isSheet(t)) {
      keep[std::max(t, twin[t])] = false;
      ++counts.reversed_triangles;
      counts.lost_backs += !pairs.isOfClosedPart(t);
      continue;
    }
    const Index front = pairs.isFront(t) ? t : twin[t], back = twin[front];
    const auto [sheet, is_new] =
        sheet_of.try_emplace({materialOf(front), materialOf(back)}, static_cast<Index>(mesh.sheets.size()));
    if (is_new) mesh.sheets.push_back({materialOf(front), materialOf(back)});
    fronts.emplace_back(front, sheet->second);
    keep[back] = false;
    ++counts.sheet_triangles;
  }
  if (fronts.empty()) return;
  mesh.materials.resize(mesh.triangles.size(), 0);
  for (const auto& [front, sheet] : fronts) mesh.materials[front] = kFirstSheet + sheet;
}

void removeDuplicates(WorkingMesh& mesh, RepairCounts& counts) {
  struct Key {
    Triangle sorted;
    Index triangle;
    bool operator<(const Key& other) const {
      return std::tie(sorted, triangle) < std::tie(other.sorted, other.triangle);
    }
  };
  std::vector<Key> keys(mesh.triangles.size());
  for (Index t = 0; t < keys.size(); ++t) {
    keys[t] = {mesh.triangles[t], t};
    std::sort(keys[t].sorted.begin(), keys[t].sorted.end());
  }
  tbb::parallel_sort(keys.begin(), keys.end());
  std::vector<bool> keep(keys.size(), true);
  std::vector<Index> twin(keys.size(), kNone);
  bool any_pair = false;
  for (std::size_t i = 1, first = 0; i < keys.size(); ++i) {
    if (keys[i].sorted != keys[first].sorted) {
      first = i;
      continue;
    }
    const Index t = keys[i].triangle, earlier = keys[first].triangle;
    const bool same = canonical(mesh.triangles[t]) == canonical(mesh.triangles[earlier]);
    if (!same && twin[earlier] == kNone) {
      twin[earlier] = t, twin[t] = earlier;
      any_pair = true;
      continue;
    }
    keep[t] = false;
    ++(same ? counts.duplicate_triangles : counts.reversed_triangles);
  }
  if (any_pair) settlePairs(mesh, twin, keep, counts);
  keepTriangles(mesh, keep);
}

// The side on the other triangle, or kNone where the surface ends or is cut.
using Opposite = std::vector<Corner>;

// Turns as few triangles of each component as needed for neighbours (across edges of two triangles) to agree.
void orient(WorkingMesh& mesh, const EdgeGroups& edges, RepairCounts& counts) {
  Opposite opposite(3 * mesh.triangles.size(), kNone);
  for (std::size_t g = 0; g < edges.count(); ++g) {
    const auto sides = edges.group(g);
    if (sides.size() == 2) opposite[sides[0]] = sides[1], opposite[sides[1]] = sides[0];
  }
  enum class State : std::uint8_t { kUnseen, kAsIs, kTurned };
  std::vector<State> state(mesh.triangles.size(), State::kUnseen);
  std::vector<Index> component;
  for (Index seed = 0; seed < mesh.triangles.size(); ++seed) {
    if (state[seed] != State::kUnseen) continue;
    component.assign(1, seed);
    state[seed] = State::kAsIs;
    std::size_t turned = 0;
    for (std::size_t next = 0; next < component.size(); ++next) {
      const Index t = component[next];
      for (Corner side = 3 * t; side < 3 * t + 3; ++side) {
        const Corner other = opposite[side];
        if (other == kNone || state[other / 3] != State::kUnseen) continue;
        const bool agree = start(mesh, side) == end(mesh, other);
        state[other / 3] = (state[t] == State::kAsIs) == agree ? State::kAsIs : State::kTurned;
        turned += state[other / 3] == State::kTurned;
        component.push_back(other / 3);
      }
    }
    const State minority = 2 * turned <= component.size() ? State::kTurned : State::kAsIs;
    for (const Index t : component) {
      if (state[t] != minority) continue;
      std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
      ++counts.reoriented_triangles;
    }
  }
}

// Across an edge of many triangles, pairs those of opposite direction that continue each other most smoothly.
void pairAcross(const WorkingMesh& mesh, std::span<const Corner> sides, Opposite& opposite) {
  struct Pair {
    double smoothness;
    Corner a, b;
  };
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    for (std::size_t j = i + 1; j < sides.size(); ++j) {
      if (start(mesh, sides[i]) != end(mesh, sides[j])) continue;
      const Vec3 na = mesh.areaVector(sides[i] / 3).normalized(),
                 nb = mesh.areaVector(sides[j] / 3).normalized();
      pairs.push_back({na.dot(nb), sides[i], sides[j]});
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.smoothness > b.smoothness; });
  for (const Pair& pair : pairs) {
    if (opposite[pair.a] != kNone || opposite[pair.b] != kNone) continue;
    opposite[pair.a] = pair.b, opposite[pair.b] = pair.a;
  }
}

Opposite pairSides(const WorkingMesh& mesh, const EdgeGroups& edges, RepairCounts& counts) {
  Opposite opposite(3 * mesh.triangles.size(), kNone);
  for (std::size_t g = 0; g < edges.count(); ++g) {
    const auto sides = edges.group(g);
    if (sides.size() > 2) ++counts.non_manifold_edges;
    if (sides.size() == 2 && start(mesh, sides[0]) == start(mesh, sides[1])) ++counts.one_sided_cuts;
    if (sides.size() >= 2) pairAcross(mesh, sides, opposite);
  }
  return opposite;
}

// Corners that reach each other around a vertex through paired sides form one fan.
std::vector<Corner> fans(const Opposite& opposite) {
  CornerSets sets(opposite.size());
  for (Corner side = 0; side < opposite.size(); ++side) {
    if (opposite[side] == kNone) continue;
    sets.join(side, nextSide(opposite[side]));
    sets.join(nextSide(side), opposite[side]);
  }
  std::vector<Corner> fan(opposite.size());
  for (Corner c = 0; c < fan.size(); ++c) fan[c] = sets.find(c);
  return fan;
}

// Cuts edges that would still join more than two triangles once each fan has its own vertex. A fan that is
// cut there ends there, so it cannot pass such an edge again: a few rounds suffice.
bool cutWhatRemains(const WorkingMesh& mesh, const EdgeGroups& edges, const std::vector<Corner>& fan,
                    Opposite& opposite) {
  bool cut = false;
  std::vector<std::pair<Corner, Corner>> ends;
  for (std::size_t g = 0; g < edges.count(); ++g) {
    const auto sides = edges.group(g);
    if (sides.size() <= 2) continue;
    ends.clear();
    for (const Corner side : sides) {
      const bool forward = start(mesh, side) < end(mesh, side);
      const Corner a = fan[side], b = fan[nextSide(side)];
      ends.push_back(forward ? std::pair(a, b) : std::pair(b, a));
    }
    std::sort(ends.begin(), ends.end());
    bool crowded = false;
    for (std::size_t i = 2; i < ends.size(); ++i) crowded |= ends[i] == ends[i - 2];
    if (!crowded) continue;
    for (const Corner side : sides) cut |= opposite[side] != kNone, opposite[side] = kNone;
  }
  return cut;
}

void splitFans(WorkingMesh& mesh, const std::vector<Corner>& fan, RepairCounts& counts) {
  std::vector<Corner> first_fan(mesh.positions.size(), kNone);
  std::vector<bool> split(mesh.positions.size());
  std::unordered_map<Corner, Index> copy;
  for (Corner c = 0; c < fan.size(); ++c) {
    Index& vertex = mesh.triangles[c / 3][c % 3];
    if (first_fan[vertex] == kNone) first_fan[vertex] = fan[c];
    if (first_fan[vertex] == fan[c]) continue;
    const auto [it, inserted] = copy.try_emplace(fan[c], static_cast<Index>(mesh.positions.size()));
    if (inserted) {
      const Vec3 position = mesh.positions[vertex];
      mesh.positions.push_back(position);
      ++counts.added_vertices;
      if (!split[vertex]) ++counts.non_manifold_vertices;
      split[vertex] = true;
    }
    vertex = it->second;
  }
}

// Whether each edge has one triangle, or two that agree, and the triangles around each vertex one fan: the
// usual case, in which there is nothing to mend.
bool isManifold(const WorkingMesh& mesh, const EdgeGroups& edges) {
  std::atomic<bool> ok = true;
  Opposite opposite(3 * mesh.triangles.size(), kNone);
  tbb::parallel_for(std::size_t{0}, edges.count(), [&](std::size_t g) {
    const auto sides = edges.group(g);
    if (sides.size() == 1) return;
    if (sides.size() > 2 || start(mesh, sides[0]) != end(mesh, sides[1])) {
      ok.store(false, std::memory_order_relaxed);
      return;
    }
    opposite[sides[0]] = sides[1], opposite[sides[1]] = sides[0];
  });
  if (!ok) return false;
  std::vector<Index> corners(mesh.positions.size());
  std::vector<Corner> any(mesh.positions.size(), kNone);
  for (Corner c = 0; c < opposite.size(); ++c) {
    Corner& of_vertex = any[start(mesh, c)];
    ++corners[start(mesh, c)];
    if (of_vertex == kNone || opposite[c] == kNone) of_vertex = c;
  }
  tbb::parallel_for(std::size_t{0}, any.size(), [&](std::size_t v) {
    Index met = 0;
    for (Corner c = any[v]; c != kNone;) {
      ++met;
      c = opposite[previousSide(c)];
      if (c == any[v]) break;
    }
    if (met != corners[v]) ok.store(false, std::memory_order_relaxed);
  });
  return ok;
}

void makeManifold(WorkingMesh& mesh, RepairCounts& counts) {
  const EdgeGroups edges_before(mesh);
  if (isManifold(mesh, edges_before)) return;
  orient(mesh, edges_before, counts);
  const EdgeGroups edges(mesh);
  Opposite opposite = pairSides(mesh, edges, counts);
  std::vector<Corner> fan = fans(opposite);
  while (cutWhatRemains(mesh, edges, fan, opposite)) fan = fans(opposite);
  splitFans(mesh, fan, counts);
}

// ---- components
// ----------------------------------------------------------------------------------------------------

Components components(const WorkingMesh& mesh, const EdgeGroups& edges) {
  CornerSets sets(mesh.triangles.size());
  for (std::size_t g = 0; g < edges.count(); ++g) {
    for (const Corner side : edges.group(g)) sets.join(edges.group(g)[0] / 3, side / 3);
  }
  Components result{std::vector<Index>(mesh.triangles.size()), {}};
  for (Index t = 0; t < mesh.triangles.size(); ++t) {
    const Corner root = sets.find(t);  // the component's first triangle, so already numbered
    if (root == t) result.closed.push_back(true);
    result.of_triangle[t] = root == t ? static_cast<Index>(result.count() - 1) : result.of_triangle[root];
  }
  for (std::size_t g = 0; g < edges.count(); ++g) {
    if (edges.group(g).size() == 1) result.closed[result.of_triangle[edges.group(g)[0] / 3]] = false;
  }
  return result;
}

void removeUnusedVertices(WorkingMesh& mesh) {
  std::vector<bool> used(mesh.positions.size());
  for (const Triangle& t : mesh.triangles) {
    for (const Index i : t) used[i] = true;
  }
  std::vector<Index> renumbered(mesh.positions.size());
  Index kept = 0;
  for (Index i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    mesh.positions[kept] = mesh.positions[i];
    renumbered[i] = kept++;
  }
  mesh.positions.resize(kept);
  for (Triangle& t : mesh.triangles) {
    for (Index& i : t) i = renumbered[i];
  }
}

}  // namespace

bool RepairCounts::clean() const {
  return welded_vertices + repeated_index_triangles + duplicate_triangles + reversed_triangles +
             sheet_triangles + zero_area_triangles + kept_needles + non_manifold_edges +
             non_manifold_vertices + reoriented_triangles + one_sided_cuts + inside_out_components +
             isolated_vertices ==
         0;
}

std::vector<std::uint32_t> weldedVertices(const std::vector<Vec3>& positions, double weld_tolerance) {
  // Coordinates this far out are no finer, so less is none at all.
  double largest = 0;
  for (const Vec3& p : positions) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  const double finest = 4 * std::numeric_limits<double>::epsilon() * largest;
  return weld_tolerance > finest ? nearRepresentatives(positions, weld_tolerance)
                                 : exactRepresentatives(positions);
}

RepairCounts repair(WorkingMesh& mesh, double weld_tolerance) {
  RepairCounts counts;
  weld(mesh, weld_tolerance, counts);
  removeRepeatedIndices(mesh, counts);
  removeDuplicates(mesh, counts);
  makeManifold(mesh, counts);
  removeUnusedVertices(mesh);
  std::vector<WorkingMesh::Sheet> sheets = std::move(mesh.sheets);
  const NeedleCounts needles = removeNeedles(mesh, kNeedleHeight);
  mesh.sheets = std::move(sheets);
  counts.zero_area_triangles = needles.removed;
  counts.kept_needles = needles.kept;
  counts.inside_out_components = turnInsideOutComponents(mesh, components(mesh, EdgeGroups(mesh)));
  return counts;
}

Topology topology(const WorkingMesh& mesh) {
  const EdgeGroups edges(mesh);
  Topology result;
  result.components = static_cast<std::int64_t>(components(mesh, edges).count());
  for (std::size_t g = 0; g < edges.count(); ++g) result.boundary_edges += edges.group(g).size() == 1;
  result.euler_characteristic = static_cast<std::int64_t>(mesh.positions.size()) -
                                static_cast<std::int64_t>(edges.count()) +
                                static_cast<std::int64_t>(mesh.triangles.size());
  return result;
}

}  // namespace bakelight::surface
