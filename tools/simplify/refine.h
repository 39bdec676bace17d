// Splits edges that are far longer than those of the mesh asked for.
#pragma once

#include <cstdint>

#include "surface/corner_mesh.h"
#include "tools/simplify/surface_words.h"

namespace bakelight::simplify {

// Halves edges longer than `max_length`, the longest first, at most `max_splits` times. The surface stays as
// it is; large flat triangles, such as those that close a scan's holes, become as small as the others, for
// decimation to choose from. Marks must be set afterwards. Returns the number of splits.
std::int64_t splitLongEdges(CornerMesh& mesh, double max_length, std::int64_t max_splits);

}  // namespace bakelight::simplify
