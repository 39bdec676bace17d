#include "tools/simplify/working_mesh.h"

namespace bakelight::simplify {

WorkingMesh workingMesh(const formats::TriangleMesh& mesh) {
  WorkingMesh working;
  working.positions.reserve(mesh.vertexCount());
  for (const formats::Float3& position : mesh.positions)
    working.positions.push_back(transport::vec3(position));
  working.triangles = mesh.triangles;
  return working;
}

}  // namespace bakelight::simplify
