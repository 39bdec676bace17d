// Divides a surface into pieces that are likely to lie flat: compact, and of similar normals.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tools/atlas/charts/surface.h"

namespace bakelight::atlas {

// Variational shape approximation (Cohen-Steiner, Alliez & Desbrun 2004) of a connected set of triangles into
// `count` pieces, with the distance to the piece's centre added to the deviation of normals: a label 0 …
// count − 1 for each of `triangles`. Every piece is connected (across edges that can be passed) and none is
// empty, if there are that many triangles. Cost: O(n log n) a round, some ten rounds.
std::vector<std::int32_t> cluster(const Surface& surface, std::span<const std::uint32_t> triangles,
                                  int count);

// Straightens the borders between pieces: a triangle changes to a neighbouring piece while that makes the
// borders shorter, as long as no piece is torn or vanishes. `labels` has one a triangle of the surface;
// triangles of different `regions` never share a piece. Cost: O(n log n).
void straightenBorders(const Surface& surface, std::span<const std::int32_t> regions,
                       std::span<std::int32_t> labels);

}  // namespace bakelight::atlas
