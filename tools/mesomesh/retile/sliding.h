// Vertices evened out on the original surface.
#pragma once

#include "tools/mesomesh/retile/original_surface.h"

namespace bakelight::mesomesh {

// Moves each vertex `rounds` times to the middle of its neighbours, within its tangent plane, and back onto
// the original: onto its region, or its curve; corners stay. All at once from the places before, so the
// result depends on no order. All TBB threads.
void evenOut(SlidingMesh& mesh, const OriginalSurface& original, int rounds);

// Puts the vertices from `first` on onto the original.
void drop(SlidingMesh& mesh, const OriginalSurface& original, std::size_t first);

// Triangles that face away from the original below them.
std::size_t foldedTriangles(const SlidingMesh& mesh, const OriginalSurface& original);

}  // namespace bakelight::mesomesh
