// How wide patches lie on a surface.
#pragma once

#include <map>
#include <string>

#include "formats/meso_mesh.h"

namespace bakelight::idmap {

// By material ("" for a mesh that tells none apart) the width of its patch in the mesh's unit: the median over edges
// that run along u, and along which places change as they do inside of the patch, of length ÷ change. Materials
// without such edges are left out. Cost: O(triangles · log triangles).
std::map<std::string, double> patchWidths(const formats::MesoMesh& meso);

}  // namespace bakelight::idmap
