#include "tools/mesomesh/field/cluster_graph.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "transport/mesh_topology.h"

namespace bakelight::mesomesh {
namespace {

constexpr std::size_t kGrain = 2048;
constexpr std::uint32_t kFree = ~std::uint32_t{0};
// Nodes whose normals differ by more than 60° are not joined: directions could hardly be carried between.
constexpr double kJoinCosine = 0.5;
// Fewer joins than this are not worth a level.
constexpr double kLeastReduction = 0.8;
// Copies of one vertex are one: joined more tightly than by an edge.
constexpr float kCopyWeight = 4;

template <class Visit>
void forAll(std::size_t count, const Visit& visit) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kGrain), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) visit(i);
  });
}

// Duff et al., Building an Orthonormal Basis, Revisited (2017).
Vec3 axisOf(const Vec3& n) {
  const double sign = std::copysign(1.0, n.z()), a = -1 / (sign + n.z());
  return {1 + sign * n.x() * n.x() * a, sign * n.x() * n.y() * a, -sign * n.x()};
}

void setAxes(ClusterLevel& level) {
  level.axes.resize(level.normals.size());
  forAll(level.normals.size(), [&](std::size_t i) { level.axes[i] = axisOf(level.normals[i]); });
}

struct Link {
  std::uint32_t to;
  float weight;
};

// Rows of links, each sorted and links to the same node made one: `gather(i, row)` fills row i.
template <class Gather>
void makeRows(ClusterLevel& level, std::size_t count, const Gather& gather) {
  const auto rowOf = [&](std::size_t i, std::vector<Link>& row) {
    row.clear();
    gather(i, row);
    std::stable_sort(row.begin(), row.end(), [](const Link& a, const Link& b) { return a.to < b.to; });
    std::size_t kept = 0;
    for (std::size_t k = 0; k < row.size(); ++k) {
      if (row[k].to == i) continue;
      if (kept > 0 && row[kept - 1].to == row[k].to)
        row[kept - 1].weight += row[k].weight;
      else
        row[kept++] = row[k];
    }
    row.resize(kept);
  };
  level.first.assign(count + 1, 0);
  const std::size_t chunks = (count + kGrain - 1) / kGrain;
  std::vector<std::vector<Link>> links(chunks);  // of the rows of each chunk, one after the other
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    std::vector<Link> row;
    for (std::size_t i = chunk * kGrain; i < std::min(count, (chunk + 1) * kGrain); ++i) {
      rowOf(i, row);
      level.first[i + 1] = static_cast<std::uint32_t>(row.size());
      links[chunk].insert(links[chunk].end(), row.begin(), row.end());
    }
  });
  std::inclusive_scan(level.first.begin(), level.first.end(), level.first.begin());
  level.neighbors.resize(level.first.back()), level.weights.resize(level.first.back());
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    std::size_t next = level.first[chunk * kGrain];
    for (const Link& link : links[chunk]) {
      level.neighbors[next] = link.to;
      level.weights[next++] = link.weight;
    }
  });
}

// The triangles around each vertex.
struct Stars {
  std::vector<std::uint32_t> first, triangles;

  explicit Stars(const formats::TriangleMesh& mesh) : first(mesh.vertexCount() + 1, 0) {
    for (const auto& t : mesh.triangles)
      for (const std::uint32_t v : t) ++first[v + 1];
    std::inclusive_scan(first.begin(), first.end(), first.begin());
    triangles.resize(first.back());
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      for (const std::uint32_t v : mesh.triangles[t]) triangles[next[v]++] = t;
  }
};

// For each vertex the vertices at its place, in rings: each names the next.
std::vector<std::uint32_t> nextCopies(const formats::TriangleMesh& mesh) {
  const std::vector<std::uint32_t> place = transport::coincidentVertices(mesh);
  std::vector<std::uint32_t> next(place.size());
  std::iota(next.begin(), next.end(), 0u);
  for (std::uint32_t v = 0; v < place.size(); ++v)
    if (place[v] != v) std::swap(next[v], next[place[v]]);
  return next;
}

ClusterLevel vertexLevel(const formats::TriangleMesh& mesh, double crease_angle_deg) {
  ClusterLevel level;
  const std::size_t count = mesh.vertexCount();
  level.normals.resize(count);
  forAll(count, [&](std::size_t v) { level.normals[v] = transport::vec3(mesh.normals[v]).normalized(); });
  level.masses.assign(count, 1);
  setAxes(level);
  const Stars stars(mesh);
  const std::vector<std::uint32_t> next_copy = nextCopies(mesh);
  const double crease_cosine = std::cos(crease_angle_deg * std::numbers::pi / 180);
  makeRows(level, count, [&](std::size_t i, std::vector<Link>& row) {
    const auto v = static_cast<std::uint32_t>(i);
    for (std::uint32_t k = stars.first[v]; k < stars.first[v + 1]; ++k)
      for (const std::uint32_t to : mesh.triangles[stars.triangles[k]])
        if (to != v) row.push_back({to, 0.5f});
    for (std::uint32_t to = next_copy[v]; to != v; to = next_copy[to])
      if (level.normals[to].dot(level.normals[v]) > crease_cosine) row.push_back({to, kCopyWeight});
  });
  return level;
}

// Vaněk, Mandel & Brezina's aggregation: a node none of whose neighbours is taken takes them all; who is left
// joins the neighbour it is tied to most.
std::uint32_t aggregate(ClusterLevel& level) {
  const std::size_t count = level.size();
  level.cluster.assign(count, kFree);
  std::uint32_t clusters = 0;
  const auto joins = [&](std::size_t i, std::size_t j) {
    return level.normals[i].dot(level.normals[j]) > kJoinCosine;
  };
  for (std::size_t i = 0; i < count; ++i) {
    if (level.cluster[i] != kFree) continue;
    bool all_free = true;
    for (std::uint32_t k = level.first[i]; k < level.first[i + 1]; ++k)
      all_free = all_free && (level.cluster[level.neighbors[k]] == kFree || !joins(i, level.neighbors[k]));
    if (!all_free) continue;
    level.cluster[i] = clusters;
    for (std::uint32_t k = level.first[i]; k < level.first[i + 1]; ++k)
      if (joins(i, level.neighbors[k])) level.cluster[level.neighbors[k]] = clusters;
    ++clusters;
  }
  const std::uint32_t seeded = clusters;
  std::vector<std::uint32_t> joined = level.cluster;
  for (std::size_t i = 0; i < count; ++i) {
    if (level.cluster[i] != kFree) continue;
    float best = 0;
    for (std::uint32_t k = level.first[i]; k < level.first[i + 1]; ++k) {
      const std::uint32_t to = level.cluster[level.neighbors[k]];
      if (to == kFree || to >= seeded || level.weights[k] <= best || !joins(i, level.neighbors[k])) continue;
      best = level.weights[k];
      joined[i] = to;
    }
    if (joined[i] == kFree) joined[i] = clusters++;
  }
  level.cluster = std::move(joined);
  return clusters;
}

ClusterLevel coarser(const ClusterLevel& fine, std::uint32_t count) {
  ClusterLevel level;
  std::vector<std::uint32_t> first(count + 1, 0), members(fine.size());
  for (const std::uint32_t c : fine.cluster) ++first[c + 1];
  std::inclusive_scan(first.begin(), first.end(), first.begin());
  std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
  for (std::uint32_t i = 0; i < fine.size(); ++i) members[next[fine.cluster[i]]++] = i;
  level.normals.resize(count), level.masses.assign(count, 0);
  forAll(count, [&](std::size_t c) {
    Vec3 sum = Vec3::Zero();
    for (std::uint32_t k = first[c]; k < first[c + 1]; ++k) {
      sum += fine.masses[members[k]] * fine.normals[members[k]];
      level.masses[c] += fine.masses[members[k]];
    }
    level.normals[c] = sum.norm() > 1e-9 ? Vec3(sum.normalized()) : fine.normals[members[first[c]]];
  });
  setAxes(level);
  makeRows(level, count, [&](std::size_t c, std::vector<Link>& row) {
    for (std::uint32_t k = first[c]; k < first[c + 1]; ++k) {
      const std::uint32_t i = members[k];
      for (std::uint32_t l = fine.first[i]; l < fine.first[i + 1]; ++l)
        row.push_back({fine.cluster[fine.neighbors[l]], fine.weights[l]});
    }
  });
  return level;
}

}  // namespace

Complex carried(const ClusterLevel& from, std::size_t i, const ClusterLevel& to, std::size_t j,
                int symmetry) {
  const Vec3 &n = from.normals[i], &m = to.normals[j];
  const double cosine = n.dot(m);
  if (cosine < -0.999) return 0;
  const Vec3& axis = from.axes[i];
  const Vec3 turned = axis - (axis.dot(m) / (1 + cosine)) * (n + m);
  Complex turn(turned.dot(to.axes[j]), turned.dot(m.cross(to.axes[j])));
  for (int n_fold = 1; n_fold < symmetry; n_fold *= 2) turn *= turn;
  return turn;
}

std::vector<ClusterLevel> clusterLevels(const formats::TriangleMesh& mesh, double crease_angle_deg,
                                        std::size_t most_nodes) {
  std::vector<ClusterLevel> levels;
  levels.push_back(vertexLevel(mesh, crease_angle_deg));
  while (levels.back().size() > most_nodes) {
    const std::uint32_t clusters = aggregate(levels.back());
    if (clusters > kLeastReduction * static_cast<double>(levels.back().size())) {
      levels.back().cluster.clear();
      break;
    }
    levels.push_back(coarser(levels.back(), clusters));
  }
  return levels;
}

}  // namespace bakelight::mesomesh
