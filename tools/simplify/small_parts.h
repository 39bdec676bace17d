// Parts of a mesh that are too small to matter.
#pragma once

#include <cstddef>

#include "surface/working_mesh.h"

namespace bakelight::simplify {

struct SmallParts {
  std::size_t parts = 0, triangles = 0;
  double area_share = 0;  // of the mesh's
};
// Removes the triangles of parts, connected through shared vertices, that have less than `least_share` of the area; the largest stays
// always. Vertices stay.
SmallParts removeSmallParts(surface::WorkingMesh& mesh, double least_share);

}  // namespace bakelight::simplify
