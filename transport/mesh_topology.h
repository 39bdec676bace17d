// How the triangles of a mesh hang together, whatever vertices were split along creases and seams.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::transport {

// For each vertex the first one at the same position.
std::vector<std::uint32_t> coincidentVertices(const formats::TriangleMesh& mesh);

// 1 for each triangle of a connected part with an open border (an edge that one triangle uses), whose back
// sides can be seen from outside. `place` is coincidentVertices(mesh): vertices at the same place count as
// one, so creases are no borders.
std::vector<std::uint8_t> openTriangles(const formats::TriangleMesh& mesh,
                                        std::span<const std::uint32_t> place);

}  // namespace bakelight::transport
