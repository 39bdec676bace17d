#include "tools/simplify/small_parts.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace bakelight::simplify {

SmallParts removeSmallParts(surface::WorkingMesh& mesh, double least_share) {
  std::vector<std::uint32_t> parent(mesh.positions.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto rootOf = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const surface::Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) parent[rootOf(v)] = rootOf(t[0]);
  std::vector<double> areas(mesh.positions.size(), 0);
  double total = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double area = mesh.areaVector(t).norm() / 2;
    areas[rootOf(mesh.triangles[t][0])] += area;
    total += area;
  }
  const double least = std::min(least_share * total, *std::max_element(areas.begin(), areas.end()));
  SmallParts removed;
  std::vector<bool> keep(mesh.triangles.size());
  for (std::size_t t = 0; t < keep.size(); ++t) {
    keep[t] = areas[rootOf(mesh.triangles[t][0])] >= least;
    removed.triangles += !keep[t];
  }
  for (std::uint32_t v = 0; v < areas.size(); ++v) {
    if (rootOf(v) != v || areas[v] >= least || areas[v] == 0) continue;
    ++removed.parts;
    removed.area_share += areas[v] / total;
  }
  if (removed.triangles > 0) surface::keepTriangles(mesh, keep);
  return removed;
}

}  // namespace bakelight::simplify
