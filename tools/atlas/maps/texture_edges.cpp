#include "tools/atlas/maps/texture_edges.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <stdexcept>
#include <tuple>

#include "transport/mesh_topology.h"

namespace bakelight::atlas {
namespace {

using formats::TriangleMesh;

// For each vertex one that stands for all with its position and texture coordinate.
std::vector<std::uint32_t> representatives(const TriangleMesh& mesh) {
  const std::vector<std::uint32_t> place = transport::coincidentVertices(mesh);
  // By bits, as what is not a number would not sort; the sum turns −0 into 0.
  const auto key = [&](std::uint32_t v) {
    const formats::Float2& uv = mesh.texcoords[v];
    return std::tuple(place[v], std::bit_cast<std::uint32_t>(uv[0] + 0.0F),
                      std::bit_cast<std::uint32_t>(uv[1] + 0.0F));
  };
  std::vector<std::uint32_t> order(mesh.vertexCount()), result(mesh.vertexCount());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return std::tuple(key(a), a) < std::tuple(key(b), b); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
    result[order[i]] = same ? result[order[i - 1]] : order[i];
  }
  return result;
}

}  // namespace

void forEachTextureEdge(const TriangleMesh& mesh,
                        const std::function<void(std::span<const TextureEdge>)>& visit) {
  if (mesh.texcoords.size() != mesh.vertexCount())
    throw std::logic_error("the mesh has no texture coordinates");
  const std::vector<std::uint32_t> vertex = representatives(mesh);
  std::vector<TextureEdge> uses;
  uses.reserve(3 * mesh.triangleCount());
  for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t)
    for (std::uint8_t k = 0; k < 3; ++k) {
      const std::uint32_t a = vertex[mesh.triangles[t][k]], b = vertex[mesh.triangles[t][(k + 1) % 3]];
      if (a != b) uses.push_back({std::min(a, b), std::max(a, b), t, k, a < b});
    }
  std::sort(uses.begin(), uses.end(), [](const TextureEdge& a, const TextureEdge& b) {
    return std::tie(a.low, a.high, a.triangle, a.edge) < std::tie(b.low, b.high, b.triangle, b.edge);
  });
  for (std::size_t begin = 0, end; begin < uses.size(); begin = end) {
    end = begin + 1;
    while (end < uses.size() && uses[end].low == uses[begin].low && uses[end].high == uses[begin].high) ++end;
    visit(std::span(uses).subspan(begin, end - begin));
  }
}

bool isInner(std::span<const TextureEdge> uses) {
  const auto upwards =
      std::count_if(uses.begin(), uses.end(), [](const TextureEdge& e) { return e.upwards; });
  return 2 * static_cast<std::size_t>(upwards) == uses.size();
}

std::vector<TextureEdge> borderEdges(const TriangleMesh& mesh) {
  std::vector<TextureEdge> borders;
  forEachTextureEdge(mesh, [&](std::span<const TextureEdge> uses) {
    if (!isInner(uses)) borders.insert(borders.end(), uses.begin(), uses.end());
  });
  std::sort(borders.begin(), borders.end(), [](const TextureEdge& a, const TextureEdge& b) {
    return std::tie(a.triangle, a.edge) < std::tie(b.triangle, b.edge);
  });
  return borders;
}

}  // namespace bakelight::atlas
