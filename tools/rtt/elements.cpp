#include "tools/rtt/elements.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "patch/subdivision.h"
#include "transport/morton.h"
#include "transport/vector_types.h"

namespace bakelight::rtt {
namespace {

using formats::TriangleMesh;
using transport::vec3;

// Of any edge, so that needles count as what they become.
double estimatedTriangles(const TriangleMesh& mesh, double longest_edge) {
  double count = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto pieces = [&](std::uint32_t from, std::uint32_t to) {
      return std::max(1.0, (vec3(mesh.positions[from]) - vec3(mesh.positions[to])).norm() / longest_edge);
    };
    std::array<double, 3> edges = {pieces(a, b), pieces(b, c), pieces(c, a)};
    std::sort(edges.begin(), edges.end());
    count += edges[1] * edges[0] * 2;  // halving overshoots
  }
  return count;
}

template <class Value>
void reorder(std::vector<Value>& values, const std::vector<std::uint32_t>& order) {
  if (values.empty()) return;
  std::vector<Value> ordered(values.size());
  for (std::size_t i = 0; i < order.size(); ++i) ordered[i] = values[order[i]];
  values = std::move(ordered);
}

void orderAlongCurve(TriangleMesh& mesh) {
  const std::vector<std::uint32_t> order = transport::mortonOrder(mesh.positions);
  std::vector<std::uint32_t> place(order.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) place[order[i]] = i;
  reorder(mesh.positions, order);
  reorder(mesh.normals, order);
  reorder(mesh.colors, order);
  reorder(mesh.texcoords, order);
  for (auto& triangle : mesh.triangles)
    for (std::uint32_t& v : triangle) v = place[v];
  std::vector<std::uint32_t> by_first(mesh.triangleCount());
  std::iota(by_first.begin(), by_first.end(), 0U);
  std::stable_sort(by_first.begin(), by_first.end(), [&](std::uint32_t a, std::uint32_t b) {
    return *std::min_element(mesh.triangles[a].begin(), mesh.triangles[a].end()) <
           *std::min_element(mesh.triangles[b].begin(), mesh.triangles[b].end());
  });
  reorder(mesh.triangles, by_first);
  reorder(mesh.triangle_materials, by_first);
}

}  // namespace

patch::PatchGeometry withElements(const patch::PatchGeometry& geometry, double& longest_edge,
                                  std::size_t most_triangles) {
  const double most = std::max<double>(static_cast<double>(most_triangles),
                                       static_cast<double>(2 * geometry.mesh.triangleCount()));
  while (estimatedTriangles(geometry.mesh, longest_edge) > most) longest_edge *= 1.25;
  patch::PatchGeometry finer = geometry;
  finer.mesh = patch::subdivided(geometry.mesh, longest_edge);
  orderAlongCurve(finer.mesh);
  return finer;
}

}  // namespace bakelight::rtt
