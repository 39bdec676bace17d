// Straight on over the surface, beyond the edge of a chart.
#pragma once

#include <optional>

#include "tools/atlas/charts/surface.h"

namespace bakelight::atlas {

struct WalkEnd {
  std::uint32_t triangle;  // of the surface
  Vec3 weights;            // of its corners, not negative
  Vec3 direction;          // of the walk there: unit length, in the triangle's plane
};

// From the point a share `along` of the way from corner k to the next, across that edge: `forward` and
// `outward` are what the way has along the edge and at right angles to it, its length the root of their
// squares, in the surface's unit. Triangles are unfolded about their common edges, so the way is a geodesic.
// Nothing where the surface ends before. `outward` must be positive. Cost: triangles on the way.
std::optional<WalkEnd> walkAcross(const Surface& surface, std::uint32_t triangle, std::size_t k, double along,
                                  double forward, double outward);

}  // namespace bakelight::atlas
