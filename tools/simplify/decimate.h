// Edge collapse to a target number of triangles.
#pragma once

#include <cstddef>

#include "surface/collapse.h"
#include "surface/corner_mesh.h"
#include "tools/simplify/surface_words.h"

namespace bakelight::simplify {

const char* name(DecimationLevel level);

struct DecimationResult {
  std::size_t triangles = 0;  // left
  std::size_t collapses = 0;
  DecimationLevel level = DecimationLevel::kFull;
  bool reached = true;  // false: topology forbids fewer triangles (4 for each closed component)
};

// Half-edge collapses by least mean quadric error (Garland & Heckbert 1997) with a pull towards edges of
// similar length, until `target` triangles (one less where an odd number meets a closed surface) are left.
// Marked features (features.h) collapse along themselves only, locked vertices stay, triangles turn by at
// most 60° a collapse; those constraints are dropped one after the other if the target cannot be reached
// otherwise. The shape of triangles is left to relax(): demanding it here blocks the best collapses and costs
// a third more deviation.
//
// In rounds: among the cheapest collapses of all, those that are the cheapest of their surroundings run at
// once; what lies next to a vertex of very many triangles follows one by one. All TBB threads, the same bytes
// for any number of them. Cost: O(n), 5 to 10 µs of one core for each triangle removed.
DecimationResult decimate(CornerMesh& mesh, std::size_t target);

}  // namespace bakelight::simplify
