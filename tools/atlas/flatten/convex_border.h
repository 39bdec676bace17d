// The border of a chart as a convex polygon whose corners lie on a circle (bi-scale radiance transfer,
// section 4.3).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tools/atlas/charts/border_notches.h"
#include "tools/atlas/charts/chart.h"

namespace bakelight::atlas {

struct ConvexBorder {
  std::vector<Vec2> points;            // one a vertex of chart.borders[0], in that order, counter-clockwise
  std::vector<std::uint8_t> inside;    // 1: the vertex lies inside the polygon, its point does not count
  std::vector<NotchTriangle> notches;  // between those vertices and the polygon
  std::vector<std::uint32_t> corners;  // indices into that border, ascending
  std::int64_t added_corners = 0;      // beyond those chosen, see below
  std::int64_t bulged_sides = 0;
  std::int64_t shortened_sides = 0;
};

// The radius of the circle whose chords of these lengths close to a polygon, each as long as its length.
// Lengths are positive, at least three, the largest less than the sum of the others; the centre may lie
// outside the polygon. To 1e-14, relative.
double circumradius(std::span<const double> lengths);

// Corners are `chosen`, vertices of the chart; those that do not lie on its outer border do not count.
// Without any, `count` corners (at least 3, at most one a vertex of the border) subdivide the border's length
// uniformly, snapped to the nearest vertices. Sides are as long as the border's paths between corners, and
// vertices divide a side as their path lengths do. Four exceptions keep the polygon convex and the interior
// one-to-one:
// - A path is given a further corner at its middle if it is longer than 98% of the others together, as their
//   chords could hardly close it, or if there are fewer than three corners. If it is one edge, its side is
//   shortened as far as needed.
// - An inner edge that joins two vertices of one side cuts off triangles (teeth of a jagged border), which
//   would lie flat on a straight side. One of its ends goes inside the polygon if the border is reentrant
//   there, or about straight at the foot of a small tooth; so teeth stand on the side, which is their hull.
// - If neither end is, the side is bulged onto the circle's arc (at most 30° to each side of its middle).
// - No edge is shorter than 1e-6 of its side ÷ the side's edges.
// `chart` is planar, with at least 3 vertices in borders[0]. Cost: O(triangles).
ConvexBorder convexBorder(const Chart& chart, std::span<const std::uint32_t> chosen, int count);

}  // namespace bakelight::atlas
