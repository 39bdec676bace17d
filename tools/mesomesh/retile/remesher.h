// Isotropic remeshing by local operations: Botsch & Kobbelt, A Remeshing Approach to Multiresolution
// Modeling (2004), section 4.
#pragma once

#include <cstddef>

#include "tools/mesomesh/retile/original_surface.h"

namespace bakelight::mesomesh {

// One round at the edge length asked for: splits edges longer than 4/3 of it, collapses those shorter than
// 4/5, flips towards six neighbours a vertex, evens out. Features, and on each curve at least one vertex
// between its corners, are kept; no component vanishes. Sequential but for the last step, so deterministic.
// No more than `max_vertices` come to be by splits. Leaves removed vertices and triangles in place.
void remeshOnce(SlidingMesh& mesh, const OriginalSurface& original, double edge_length,
                std::size_t max_vertices);

// Flips alone, and evening out, `rounds` times.
void polish(SlidingMesh& mesh, const OriginalSurface& original, int rounds);

// Without what was removed; triangles along a space-filling curve, vertices as triangles first use them:
// neighbours on the surface are neighbours in memory.
SlidingMesh compacted(const SlidingMesh& mesh);

}  // namespace bakelight::mesomesh
