// Rounding of flat charts to the floats that are written.
#pragma once

#include <cstdint>
#include <span>

#include "tools/atlas/charts/surface.h"

namespace bakelight::atlas {

// Moves vertices, whose coordinates are floats in [0, 1], by a few 2⁻²⁴ where rounding has flipped or
// flattened a triangle (exact test), such that none of their triangles is; each at most 64 times that.
// Deterministic. Returns how many were moved; triangles so thin that no such place is near stay as they are.
std::int64_t nudgeFlipped(std::span<const Triangle> triangles, std::span<formats::Float2> texcoords);

}  // namespace bakelight::atlas
