#include "transport/mesh_topology.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace bakelight::transport {

using formats::TriangleMesh;

std::vector<std::uint32_t> coincidentVertices(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> order(mesh.vertexCount()), place(mesh.vertexCount());
  std::iota(order.begin(), order.end(), 0u);
  tbb::parallel_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return mesh.positions[a] != mesh.positions[b] ? mesh.positions[a] < mesh.positions[b] : a < b;
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && mesh.positions[order[i]] == mesh.positions[order[i - 1]];
    place[order[i]] = same ? place[order[i - 1]] : order[i];
  }
  return place;
}

std::vector<std::uint8_t> openTriangles(const TriangleMesh& mesh, std::span<const std::uint32_t> place) {
  // Components by union-find over places; an edge that one triangle uses is a border.
  std::vector<std::uint32_t> parent(mesh.vertexCount());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& triangle : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = place[triangle[i]], b = place[triangle[(i + 1) % 3]];
      if (a == b) continue;
      edges.emplace_back(std::min(a, b), std::max(a, b));
      parent[root(a)] = root(b);
    }
  tbb::parallel_sort(edges.begin(), edges.end());
  std::vector<std::uint8_t> open_root(mesh.vertexCount(), 0);
  for (std::size_t first = 0; first < edges.size();) {
    std::size_t end = first;
    while (end < edges.size() && edges[end] == edges[first]) ++end;
    if (end - first == 1) open_root[root(edges[first].first)] = 1;
    first = end;
  }
  std::vector<std::uint8_t> open;
  open.reserve(mesh.triangleCount());
  for (const auto& triangle : mesh.triangles) open.push_back(open_root[root(place[triangle[0]])]);
  return open;
}

}  // namespace bakelight::transport
