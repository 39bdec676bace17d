// What the materials of a mesh's triangles (TriangleMesh::triangle_materials) are asked for.
#pragma once

#include <cstddef>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::formats {

// Throws std::logic_error unless each triangle has one of the named materials, or none has and there are no
// names.
void requireMaterials(const TriangleMesh& mesh);

// How many triangles have each of the named materials.
std::vector<std::size_t> trianglesOfMaterials(const TriangleMesh& mesh);

// How many materials have a triangle.
std::size_t usedMaterials(const TriangleMesh& mesh);

}  // namespace bakelight::formats
