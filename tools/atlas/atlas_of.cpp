#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "tools/atlas/atlas.h"
#include "tools/atlas/maps/texture_edges.h"

namespace bakelight::atlas {
namespace {

using formats::TriangleMesh;

std::uint32_t copyVertex(TriangleMesh& mesh, std::uint32_t vertex) {
  mesh.positions.push_back(mesh.positions[vertex]);
  mesh.texcoords.push_back(mesh.texcoords[vertex]);
  if (!mesh.normals.empty()) mesh.normals.push_back(mesh.normals[vertex]);
  if (!mesh.colors.empty()) mesh.colors.push_back(mesh.colors[vertex]);
  return static_cast<std::uint32_t>(mesh.vertexCount() - 1);
}

// The chart with the first triangle at a vertex keeps it, the others get copies.
void separateVertices(Atlas& atlas) {
  constexpr std::uint32_t kFree = ~0u;
  std::vector<std::uint32_t> owner(atlas.mesh.vertexCount(), kFree);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> copies;  // by vertex and chart
  for (std::size_t t = 0; t < atlas.mesh.triangleCount(); ++t) {
    const std::uint32_t chart = atlas.triangle_charts[t];
    for (std::uint32_t& vertex : atlas.mesh.triangles[t]) {
      if (owner[vertex] == kFree) owner[vertex] = chart;
      if (owner[vertex] == chart) continue;
      const auto [copy, is_new] = copies.try_emplace({vertex, chart}, 0);
      if (is_new) copy->second = copyVertex(atlas.mesh, vertex);
      vertex = copy->second;
    }
  }
}

}  // namespace

Atlas atlasOf(TriangleMesh mesh) {
  std::vector<std::uint32_t> parent(mesh.triangleCount());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t t) {
    while (parent[t] != t) t = parent[t] = parent[parent[t]];
    return t;
  };
  forEachTextureEdge(mesh, [&](std::span<const TextureEdge> uses) {
    const auto runsUp = [](const TextureEdge& use) { return use.upwards; };
    if (std::all_of(uses.begin(), uses.end(), runsUp) || std::none_of(uses.begin(), uses.end(), runsUp))
      return;
    for (const TextureEdge& use : uses.subspan(1)) {
      const std::uint32_t a = root(uses[0].triangle), b = root(use.triangle);
      parent[std::max(a, b)] = std::min(a, b);
    }
  });

  Atlas atlas;
  atlas.triangle_charts.resize(mesh.triangleCount());
  // A root is the first triangle of its chart, so its number is known when others ask for it.
  for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t)
    atlas.triangle_charts[t] = root(t) == t ? atlas.chart_count++ : atlas.triangle_charts[root(t)];
  atlas.mesh = std::move(mesh);
  separateVertices(atlas);
  return atlas;
}

}  // namespace bakelight::atlas
