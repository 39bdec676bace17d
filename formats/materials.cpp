#include "formats/materials.h"

#include <algorithm>
#include <stdexcept>

namespace bakelight::formats {

void requireMaterials(const TriangleMesh& mesh) {
  const auto& materials = mesh.triangle_materials;
  const bool complete = materials.empty() ? mesh.material_names.empty() || mesh.triangles.empty()
                                          : materials.size() == mesh.triangleCount();
  if (!complete) throw std::logic_error("a mesh has materials for all triangles or for none");
  for (const std::uint32_t material : materials) {
    if (material >= mesh.material_names.size())
      throw std::logic_error("a triangle has a material that the mesh does not name");
  }
}

std::vector<std::size_t> trianglesOfMaterials(const TriangleMesh& mesh) {
  std::vector<std::size_t> triangles(mesh.material_names.size());
  for (const std::uint32_t material : mesh.triangle_materials) ++triangles[material];
  return triangles;
}

std::size_t usedMaterials(const TriangleMesh& mesh) {
  const std::vector<std::size_t> triangles = trianglesOfMaterials(mesh);
  return triangles.size() - static_cast<std::size_t>(std::count(triangles.begin(), triangles.end(), 0U));
}

}  // namespace bakelight::formats
