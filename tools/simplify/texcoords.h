// Texture coordinates carried through a repair.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/triangle_mesh.h"
#include "surface/working_mesh.h"
#include "tools/simplify/surface_words.h"

namespace bakelight::simplify {

using CornerTexcoords = std::array<formats::Float2, 3>;

// Texture coordinates of the corners of `repaired`'s triangles: those of the input's triangle with the same
// three places that faces the same way, or else the other; the first one if there are several. `original` is
// the input's mesh before the repair, with its vertices in the same order, `weld_tolerance` that of the
// repair. Empty if any triangle has no counterpart, as the repair may move corners and flip edges of
// triangles without area. Cost: O(n log n).
std::vector<CornerTexcoords> texcoordsThroughRepair(const formats::TriangleMesh& input,
                                                    const WorkingMesh& original, double weld_tolerance,
                                                    const WorkingMesh& repaired);

// Gives the corners of the triangles their texture coordinates. A vertex whose corners differ is copied;
// copies follow at the end, in the order of triangles. Returns how many. `mesh` has normals, no colours.
std::int64_t setTexcoords(formats::TriangleMesh& mesh, std::span<const CornerTexcoords> corners);

}  // namespace bakelight::simplify
