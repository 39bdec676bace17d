// Surfaces with borders, made by code, as charts.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include "tests/support/shapes.h"
#include "tools/atlas/charts/chart.h"

namespace bakelight::tests {

// Hexagonal rings around a vertex: ring k has 6k vertices, at the positions that place(k ÷ rings, angle)
// gives. Counter-clockwise if `place` keeps the order of angles.
template <class Place>
TriangleMesh rings(int count, const Place& place) {
  TriangleMesh mesh;
  std::map<std::pair<int, int>, std::uint32_t> index;  // of lattice points by axial coordinates
  const std::pair<int, int> directions[6] = {{-1, 1}, {-1, 0}, {0, -1}, {1, -1}, {1, 0}, {0, 1}};
  for (int k = 0; k <= count; ++k) {
    std::pair<int, int> at = {k, 0};
    for (int j = 0; j < std::max(6 * k, 1); ++j) {
      index[at] = static_cast<std::uint32_t>(mesh.positions.size());
      const double angle = k == 0 ? 0 : 2 * std::numbers::pi * j / (6 * k);
      mesh.positions.push_back(float3(place(static_cast<double>(k) / count, angle)));
      if (k == 0) break;
      at.first += directions[j / k].first, at.second += directions[j / k].second;
    }
  }
  for (const auto& [at, a] : index) {
    const auto [q, r] = at;
    const auto b = index.find({q + 1, r}), c = index.find({q, r + 1}), d = index.find({q - 1, r + 1});
    if (b != index.end() && c != index.end()) mesh.triangles.push_back({a, b->second, c->second});
    if (c != index.end() && d != index.end()) mesh.triangles.push_back({a, c->second, d->second});
  }
  return mesh;
}

inline TriangleMesh flatDisk(int ring_count) {
  return rings(ring_count,
               [](double r, double angle) { return Vec3(r * std::cos(angle), r * std::sin(angle), 0); });
}

// The part of the unit sphere within `angle_deg` of its +Z pole.
inline TriangleMesh dome(int ring_count, double angle_deg) {
  return rings(ring_count, [&](double r, double angle) {
    const double polar = r * angle_deg * std::numbers::pi / 180;
    return Vec3(std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle), std::cos(polar));
  });
}

// A cone of unequal triangles around the vertex 0.
inline TriangleMesh fan(int sides, double height) {
  TriangleMesh mesh;
  mesh.positions.push_back(float3(Vec3(0, 0, height)));
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.3 * std::sin(7.0 * i)) / sides;
    mesh.positions.push_back(float3(Vec3(std::cos(angle), std::sin(angle), 0)));
    mesh.triangles.push_back(
        {0, 1 + static_cast<std::uint32_t>(i), 1 + static_cast<std::uint32_t>((i + 1) % sides)});
  }
  return mesh;
}

// The whole mesh as one chart.
inline atlas::Chart wholeChart(const TriangleMesh& mesh) {
  const atlas::Surface surface = atlas::surfaceOf(mesh, "made.ply");
  std::vector<std::uint32_t> all(surface.triangleCount());
  std::iota(all.begin(), all.end(), 0u);
  return atlas::chartOf(surface, all);
}

}  // namespace bakelight::tests
