#include "tools/simplify/half_edge_mesh.h"

#include <stdexcept>

namespace bakelight::simplify {

HalfEdgeMesh halfEdgeMesh(const WorkingMesh& mesh) {
  HalfEdgeMesh half_edges;
  half_edges.reserve(mesh.positions.size(), 3 * mesh.triangles.size() / 2 + 3, mesh.triangles.size());
  for (const Vec3& position : mesh.positions) half_edges.add_vertex(point(position));
  for (const Triangle& t : mesh.triangles) {
    const auto vertex = [&](int k) { return half_edges.vertex_handle(t[k]); };
    if (!half_edges.add_face(vertex(0), vertex(1), vertex(2)).is_valid()) {
      throw std::logic_error("simplify: a repaired mesh is not an oriented manifold");
    }
  }
  return half_edges;
}

WorkingMesh workingMesh(HalfEdgeMesh& half_edges) {
  half_edges.garbage_collection();
  WorkingMesh mesh;
  mesh.positions.reserve(half_edges.n_vertices());
  mesh.triangles.reserve(half_edges.n_faces());
  for (const auto vertex : half_edges.vertices()) mesh.positions.push_back(vec3(half_edges.point(vertex)));
  for (const auto face : half_edges.faces()) {
    Triangle triangle{};
    int k = 0;
    for (const auto vertex : half_edges.fv_range(face))
      triangle[k++] = static_cast<std::uint32_t>(vertex.idx());
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

}  // namespace bakelight::simplify
