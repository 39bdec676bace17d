// The border of a flat chart: all that packing needs of it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tools/atlas/packing/packing.h"

namespace bakelight::atlas {

struct ChartOutline {
  std::vector<Vec2> vertices;                       // of edges only
  std::vector<std::array<std::uint32_t, 2>> edges;  // the chart to the left
  std::vector<Vec2> hull;                           // convex, counter-clockwise
  double area = 0;                                  // of the triangles
  double upright_angle_rad = 0;  // turns the hull's box of least area upright, wider than high
};

// Edges whose two directions occur equally often in the triangles are inside; the others are kept, as many
// as there are too many. Thus the winding number of the edges is the number of triangles about a point.
// Cost: O(n log n), and O(h²) of the hull.
ChartOutline outlineOf(const FlatChart& chart);

// Lower left and upper right of the points turned by `angle_rad`.
std::array<Vec2, 2> turnedBox(const std::vector<Vec2>& points, double angle_rad);

}  // namespace bakelight::atlas
