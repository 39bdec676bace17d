#include "tools/simplify/repair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "tools/simplify/edge_groups.h"
#include "tools/simplify/inside_out.h"
#include "tools/simplify/needles.h"

namespace bakelight::simplify {
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

using Cell = std::array<std::int64_t, 3>;
struct CellHash {
  std::size_t operator()(const Cell& c) const {
    std::uint64_t h = 0x9E3779B97F4A7C15u;
    for (const std::int64_t x : c)
      h = (h ^ static_cast<std::uint64_t>(x)) * 0xD6E8FEB86659FD93u, h ^= h >> 32;
    return h;
  }
};

// Exact coincidence: sort by coordinates, the earliest index of each run represents it.
std::vector<Index> exactRepresentatives(const std::vector<Vec3>& positions) {
  std::vector<Index> order(positions.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](Index i) {
    return std::array<double, 3>{positions[i].x(), positions[i].y(), positions[i].z()};
  };
  std::sort(order.begin(), order.end(), [&](Index a, Index b) {
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

// Each vertex joins the first earlier representative within the tolerance, found through a grid of that cell
// size.
std::vector<Index> nearRepresentatives(const std::vector<Vec3>& positions, double tolerance) {
  std::unordered_map<Cell, std::vector<Index>, CellHash> grid;
  grid.reserve(positions.size());
  std::vector<Index> representative(positions.size());
  for (Index i = 0; i < positions.size(); ++i) {
    Cell cell;
    for (int k = 0; k < 3; ++k) cell[k] = static_cast<std::int64_t>(std::floor(positions[i][k] / tolerance));
    Index found = kNone;
    for (int n = 0; n < 27; ++n) {
      const auto it = grid.find({cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1});
      if (it == grid.end()) continue;
      for (const Index other : it->second) {
        if (other < found && (positions[other] - positions[i]).norm() <= tolerance) found = other;
      }
    }
    representative[i] = found == kNone ? i : found;
    if (found == kNone) grid[cell].push_back(i);
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
  counts.repeated_index_triangles += static_cast<std::int64_t>(std::erase_if(
      mesh.triangles, [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }));
}

// The same triangle, turned so that its smallest index comes first: equal for equal orientation.
Triangle canonical(Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
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
  std::sort(keys.begin(), keys.end());
  std::vector<bool> removed(keys.size());
  for (std::size_t i = 1, first = 0; i < keys.size(); ++i) {
    if (keys[i].sorted != keys[first].sorted) {
      first = i;
      continue;
    }
    removed[keys[i].triangle] = true;
    const bool same =
        canonical(mesh.triangles[keys[i].triangle]) == canonical(mesh.triangles[keys[first].triangle]);
    ++(same ? counts.duplicate_triangles : counts.reversed_triangles);
  }
  std::size_t kept = 0;
  for (std::size_t t = 0; t < keys.size(); ++t) {
    if (!removed[t]) mesh.triangles[kept++] = mesh.triangles[t];
  }
  mesh.triangles.resize(kept);
}

// ---- orientation and manifoldness
// ----------------------------------------------------------------------------------

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

void makeManifold(WorkingMesh& mesh, RepairCounts& counts) {
  const EdgeGroups edges_before(mesh);
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
             zero_area_triangles + kept_needles + non_manifold_edges + non_manifold_vertices +
             reoriented_triangles + one_sided_cuts + inside_out_components + isolated_vertices ==
         0;
}

std::vector<std::uint32_t> weldedVertices(const std::vector<Vec3>& positions, double weld_tolerance) {
  return weld_tolerance > 0 ? nearRepresentatives(positions, weld_tolerance)
                            : exactRepresentatives(positions);
}

RepairCounts repair(WorkingMesh& mesh, double weld_tolerance) {
  RepairCounts counts;
  weld(mesh, weld_tolerance, counts);
  removeRepeatedIndices(mesh, counts);
  removeDuplicates(mesh, counts);
  makeManifold(mesh, counts);
  removeUnusedVertices(mesh);
  const NeedleCounts needles = removeNeedles(mesh, kNeedleHeight);
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

}  // namespace bakelight::simplify
