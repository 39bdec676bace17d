#include "tools/simplify/double_sided.h"

#include <limits>
#include <utility>
#include <vector>

#include "transport/mesh_topology.h"

namespace bakelight::simplify {

std::uint64_t addBacks(formats::TriangleMesh& mesh) {
  return addBacksTo(mesh, transport::openTriangles(mesh, transport::coincidentVertices(mesh)));
}

std::uint64_t addBacksTo(formats::TriangleMesh& mesh, const std::vector<std::uint8_t>& has_back) {
  constexpr std::uint32_t kNoVertex = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> back_of(mesh.vertexCount(), kNoVertex);
  const std::size_t fronts = mesh.triangleCount();
  for (std::size_t t = 0; t < fronts; ++t) {
    if (has_back[t] == 0) continue;
    formats::Triangle back = mesh.triangles[t];
    for (std::uint32_t& v : back) {
      if (back_of[v] == kNoVertex) {
        back_of[v] = static_cast<std::uint32_t>(mesh.vertexCount());
        mesh.positions.push_back(formats::Float3(mesh.positions[v]));
        const formats::Float3 normal = mesh.normals[v];
        mesh.normals.push_back({-normal[0], -normal[1], -normal[2]});
        if (!mesh.texcoords.empty()) mesh.texcoords.push_back(formats::Float2(mesh.texcoords[v]));
        if (!mesh.colors.empty()) mesh.colors.push_back(formats::Float3(mesh.colors[v]));
      }
      v = back_of[v];
    }
    std::swap(back[1], back[2]);
    mesh.triangles.push_back(back);
    if (!mesh.triangle_materials.empty())
      mesh.triangle_materials.push_back(std::uint32_t{mesh.triangle_materials[t]});
  }
  return mesh.triangleCount() - fronts;
}

}  // namespace bakelight::simplify
