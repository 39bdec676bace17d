// The inside of a sphere with a part removed, seen from inside: the closed form of interreflection.
//   Under a uniform sky of radiance 1 its radiosity is the same everywhere,
//   B = ρ π f / (1 − ρ (1 − f)),  f the open fraction.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "tests/support/shapes.h"

namespace bakelight::tests {

struct Cavity {
  TriangleMesh mesh;
  std::vector<double> open_fraction;  // of what each vertex sees, cosine-weighted; negative on the rim itself
  double mean_open_fraction = 0;
};

// Lambert's formula for the polygon of the rim as seen from `point`, which all of its edges lie above: the
// integral of the cosine over the opening, exact for the tessellated mesh.
inline double lambertFraction(const TriangleMesh& mesh,
                              const std::vector<std::pair<std::uint32_t, std::uint32_t>>& rim,
                              const Vec3& point, const Vec3& normal) {
  double sum = 0;
  for (const auto& [from, to] : rim) {
    const Vec3 a = (vec3(mesh.positions[from]) - point).normalized();
    const Vec3 b = (vec3(mesh.positions[to]) - point).normalized();
    const Vec3 across = a.cross(b);
    sum += std::atan2(across.norm(), a.dot(b)) * normal.dot(across.normalized());
  }
  return std::abs(sum) / (2 * std::numbers::pi);
}

inline Cavity sphericalCavity(double open_fraction, int subdivisions) {
  Cavity cavity{insideOut(icosphere(subdivisions)), {}, 0};
  TriangleMesh& mesh = cavity.mesh;
  const auto height = [&](const formats::Triangle& t) {
    return mesh.positions[t[0]][1] + mesh.positions[t[1]][1] + mesh.positions[t[2]][1];
  };
  std::sort(mesh.triangles.begin(), mesh.triangles.end(),
            [&](const auto& a, const auto& b) { return std::pair(height(a), a) < std::pair(height(b), b); });
  const auto kept =
      static_cast<std::size_t>(std::lround((1 - open_fraction) * static_cast<double>(mesh.triangleCount())));
  mesh.triangles.resize(kept);

  // Vertices that no triangle is left at go; directed edges without an opposite make the rim.
  std::map<std::uint32_t, std::uint32_t> renumbered;
  TriangleMesh compact;
  for (auto& triangle : mesh.triangles)
    for (auto& v : triangle) {
      const auto [it, is_new] = renumbered.try_emplace(v, static_cast<std::uint32_t>(renumbered.size()));
      if (is_new) compact.positions.push_back(mesh.positions[v]), compact.normals.push_back(mesh.normals[v]);
      v = it->second;
    }
  compact.triangles = mesh.triangles;
  mesh = compact;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
  std::vector<std::pair<std::uint32_t, std::uint32_t>> rim;
  std::vector<bool> on_rim(mesh.vertexCount(), false);
  for (const auto& [edge, count] : edges)
    if (!edges.contains({edge.second, edge.first}))
      rim.push_back(edge), on_rim[edge.first] = on_rim[edge.second] = true;

  int inner = 0;
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
    cavity.open_fraction.push_back(
        on_rim[v] ? -1 : lambertFraction(mesh, rim, vec3(mesh.positions[v]), vec3(mesh.normals[v])));
    if (on_rim[v]) continue;
    cavity.mean_open_fraction += cavity.open_fraction[v];
    ++inner;
  }
  cavity.mean_open_fraction /= inner;
  return cavity;
}

}  // namespace bakelight::tests
