#include "surface/working_mesh.h"

namespace bakelight::surface {

void keepTriangles(WorkingMesh& mesh, const std::vector<bool>& keep) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!keep[t]) continue;
    mesh.triangles[kept] = mesh.triangles[t];
    if (!mesh.materials.empty()) mesh.materials[kept] = mesh.materials[t];
    ++kept;
  }
  mesh.triangles.resize(kept);
  if (!mesh.materials.empty()) mesh.materials.resize(kept);
}

WorkingMesh workingMesh(const formats::TriangleMesh& mesh) {
  WorkingMesh working;
  working.positions.reserve(mesh.vertexCount());
  for (const formats::Float3& position : mesh.positions)
    working.positions.push_back(transport::vec3(position));
  working.triangles = mesh.triangles;
  working.materials = mesh.triangle_materials;
  return working;
}

}  // namespace bakelight::surface
