// Triangles split until none is long.
#pragma once

#include "formats/triangle_mesh.h"

namespace bakelight::patch {

// Edges longer than `longest_edge` (positive) are halved, again and again, and their triangles split: triangles
// that share an edge, or have edges at the same places, go on fitting. Normals (made unit), colors and texture
// coordinates are means of the ends'.
formats::TriangleMesh subdivided(const formats::TriangleMesh& mesh, double longest_edge);

}  // namespace bakelight::patch
