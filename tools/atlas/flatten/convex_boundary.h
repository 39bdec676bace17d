// A chart laid into a convex polygon whose corners lie on a circle: bi-scale radiance transfer, section 4.3,
// with the interior of Sander et al. 2001, "Texture mapping progressive meshes", section 3.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tools/atlas/charts/chart.h"

namespace bakelight::atlas {

struct ConvexOptions {
  int corners = 8;  // 3 or more, for a chart without chosen ones
};

struct ConvexChart {
  std::vector<Vec2> plane;             // of the chart's vertices, counter-clockwise, of the chart's area
  std::vector<std::uint32_t> corners;  // vertices of the chart, in order along its outer border
  double mean_value_l2 = 0, l2 = 0;    // L² stretch (stretch.h) before the stretch was minimised, and after
  std::int64_t added_corners = 0;      // convex_border.h says why
  std::int64_t bulged_sides = 0;
  std::int64_t shortened_sides = 0;
  std::int64_t vertices_inside = 0;  // of the outer border
};

// Whether convexBoundary takes the chart: a disk, holes allowed, with at least 3 vertices in its outer
// border.
bool canBeConvex(const Chart& chart);

// Corners and the outer border are those of convexBorder; `chosen_corners` are vertices of the chart, none of
// them for automatic ones. Holes keep the shape that least stretch gives them. A chart of one triangle is
// laid down as it is. No triangle is flipped or without area (tested exactly), so the map is one-to-one.
// Nothing if doubles cannot hold such a map (a finger many times as long as its girth shrinks to a point):
// split the chart then. Throws std::logic_error unless canBeConvex. Deterministic, on one thread. Cost: 500
// triangles about 10 ms, 20,000 about 1 s.
std::optional<ConvexChart> convexBoundary(const Chart& chart, std::span<const std::uint32_t> chosen_corners,
                                          const ConvexOptions& options);

}  // namespace bakelight::atlas
