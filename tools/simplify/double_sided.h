// Backs for sheets: cloth, leaves, paper.
#pragma once

#include <cstdint>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::simplify {

// Appends a turned-over copy of each connected part that has an open border, with vertices and normals of its
// own; closed parts stay as they are, as their inside is never seen. Vertices at the same place count as one,
// so creases are no borders. Returns how many triangles were added.
std::uint64_t addBacks(formats::TriangleMesh& mesh);

// The same of chosen triangles, `has_back` having one entry for each. The backs follow at the end, in order,
// their second and third corner exchanged.
std::uint64_t addBacksTo(formats::TriangleMesh& mesh, const std::vector<std::uint8_t>& has_back);

}  // namespace bakelight::simplify
