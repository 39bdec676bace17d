// Materials of one mesh as another numbers them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::idmap {

// For each triangle of `mesh` the place of its material's name in `names`; empty if the mesh tells no
// materials apart, or if there are no names. Throws Error(kBadInput) naming `file` and face: a material
// that is not among `names`, those of `names_file`.
std::vector<std::uint32_t> triangleMaterials(const formats::TriangleMesh& mesh, const std::string& file,
                                             const std::vector<std::string>& names,
                                             const std::string& names_file);

}  // namespace bakelight::idmap
