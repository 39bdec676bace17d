// How good a tiling is.
#pragma once

#include "tools/mesomesh/retile/original_surface.h"
#include "tools/mesomesh/retile/retile.h"

namespace bakelight::mesomesh {

// Sets edge_length, mean_quality, least_quality and six_neighbors. Sums are of fixed chunks in order, the same
// for any number of threads.
void measureTiling(const SlidingMesh& mesh, RetileReport& report);

// Sets largest_deviation and mean_deviation, over `diagonal`.
void measureDeviation(const SlidingMesh& mesh, const OriginalSurface& original, double diagonal,
                      RetileReport& report);

}  // namespace bakelight::mesomesh
