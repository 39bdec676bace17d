#include "tools/rtt/surface_sides.h"

#include <algorithm>
#include <numeric>

#include "patch/periodic_places.h"
#include "transport/mesh_topology.h"

namespace bakelight::rtt {
namespace {

using formats::TriangleMesh;

TriangleMesh insideOut(TriangleMesh mesh) {
  for (auto& normal : mesh.normals)
    for (float& value : normal) value = -value;
  for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

}  // namespace

SurfaceSides surfaceSides(const patch::PatchGeometry& geometry) {
  const TriangleMesh& mesh = geometry.mesh;
  SurfaceSides sides;
  sides.vertices = mesh.vertexCount();
  sides.row_of_side.assign(2 * sides.vertices, SurfaceSides::kDark);
  std::iota(sides.row_of_side.begin(),
            sides.row_of_side.begin() + static_cast<std::ptrdiff_t>(sides.vertices), 0U);
  sides.points = transport::frontPoints(mesh, transport::kDefaultBias);
  for (std::uint32_t v = 0; v < sides.vertices; ++v) sides.albedo.push_back(geometry.albedoOfVertex(v));

  const std::vector<std::uint8_t> open =
      transport::openTriangles(mesh, patch::periodicPlaces(mesh, geometry.period_x, geometry.period_y));
  if (std::find(open.begin(), open.end(), 1) == open.end()) return sides;
  const std::vector<transport::SurfacePoint> backs =
      transport::frontPoints(insideOut(mesh), transport::kDefaultBias);
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
    if (open[t] == 0) continue;
    for (const std::uint32_t v : mesh.triangles[t]) {
      std::uint32_t& row = sides.row_of_side[v + sides.vertices];
      if (row != SurfaceSides::kDark) continue;
      row = static_cast<std::uint32_t>(sides.points.size());
      sides.points.push_back(backs[v]);
      sides.albedo.push_back(formats::Float3(sides.albedo[v]));
    }
  }
  return sides;
}

}  // namespace bakelight::rtt
