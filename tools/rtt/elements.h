// The triangles that light is solved on.
#pragma once

#include "patch/patch_geometry.h"

namespace bakelight::rtt {

// The same surface, of triangles with edges no longer than `longest_edge` (in widths), vertices and triangles in an order
// in which neighbors are near each other. Where that would be more than `most_triangles`, edges stay as much longer
// as makes it fewer; then `longest_edge` is what they have.
patch::PatchGeometry withElements(const patch::PatchGeometry& geometry, double& longest_edge,
                                  std::size_t most_triangles = 4'000'000);

}  // namespace bakelight::rtt
