#include "surface/half_edge_mesh.h"

#include <stdexcept>

namespace bakelight::surface {

bool isMaterialBorder(const HalfEdgeMesh& mesh, EdgeHandle edge) {
  if (mesh.is_boundary(edge)) return false;
  const HalfedgeHandle h = mesh.halfedge_handle(edge, 0);
  return mesh.data(mesh.face_handle(h)).material != mesh.data(mesh.opposite_face_handle(h)).material;
}

HalfEdgeMesh halfEdgeMesh(const WorkingMesh& mesh) {
  HalfEdgeMesh half_edges;
  half_edges.reserve(mesh.positions.size(), 3 * mesh.triangles.size() / 2 + 3, mesh.triangles.size());
  for (const Vec3& position : mesh.positions) half_edges.add_vertex(point(position));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto vertex = [&](int k) { return half_edges.vertex_handle(mesh.triangles[t][k]); };
    const FaceHandle face = half_edges.add_face(vertex(0), vertex(1), vertex(2));
    if (!face.is_valid()) throw std::logic_error("simplify: a repaired mesh is not an oriented manifold");
    if (!mesh.materials.empty()) half_edges.data(face).material = mesh.materials[t];
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
    const std::uint32_t material = half_edges.data(face).material;
    if (material != kNoMaterial) mesh.materials.push_back(material);
  }
  return mesh;
}

}  // namespace bakelight::surface
