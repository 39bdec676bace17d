#include "tools/idmap/triangle_materials.h"

#include <algorithm>

#include "formats/error.h"

namespace bakelight::idmap {

std::vector<std::uint32_t> triangleMaterials(const formats::TriangleMesh& mesh, const std::string& file,
                                             const std::vector<std::string>& names,
                                             const std::string& names_file) {
  if (mesh.triangle_materials.empty() || names.empty()) return {};
  // Names may repeat; a material of the same place and name is the same.
  const auto placeOf = [&](std::uint32_t material) {
    const std::string& name = mesh.material_names[material];
    if (material < names.size() && names[material] == name) return static_cast<std::ptrdiff_t>(material);
    const auto found = std::find(names.begin(), names.end(), name);
    return found == names.end() ? std::ptrdiff_t{-1} : found - names.begin();
  };
  std::vector<std::ptrdiff_t> places;
  for (std::uint32_t m = 0; m < mesh.material_names.size(); ++m) places.push_back(placeOf(m));
  std::vector<std::uint32_t> materials(mesh.triangleCount());
  for (std::size_t t = 0; t < materials.size(); ++t) {
    const std::uint32_t material = mesh.triangle_materials[t];
    if (places[material] < 0)
      throw badInput({file, "face " + std::to_string(t), ""},
                     "its material \"" + mesh.material_names[material] + "\" is not in " + names_file,
                     "materials that the meso-mesh has, too", "make both from one mesh");
    materials[t] = static_cast<std::uint32_t>(places[material]);
  }
  return materials;
}

}  // namespace bakelight::idmap
