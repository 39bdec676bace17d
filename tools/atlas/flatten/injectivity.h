// Whether a flat chart is one-to-one, judged exactly.
#pragma once

#include <cstdint>
#include <span>

#include "tools/atlas/charts/chart.h"

namespace bakelight::atlas {

// Triangles whose orientation in the plane is negative (flipped) and zero (collapsed).
struct BadTriangles {
  std::int64_t flipped = 0, collapsed = 0;
  std::int64_t count() const { return flipped + collapsed; }
};
BadTriangles badTriangles(const Chart& chart, std::span<const Vec2> plane);

struct BorderEdge {
  std::size_t loop, index;  // from chart.borders[loop][index] to the next
};
struct BorderCrossing {
  BorderEdge a, b;
};
// Edges of the chart's borders that cross or overlap (segmentsCross), at most so many of them.
std::vector<BorderCrossing> borderCrossings(const Chart& chart, std::span<const Vec2> plane,
                                            std::size_t most);

// Whether there are any.
bool bordersCross(const Chart& chart, std::span<const Vec2> plane);

// One border goes around the chart counter-clockwise, all others, if any, around holes clockwise. Borders
// that do not cross may still be wrong: that of a hole, turned inside out.
bool bordersTurnRight(const Chart& chart, std::span<const Vec2> plane);

// No triangle is flipped or collapsed, no border crosses itself or another one, and they turn the right way.
// For a disk with holes that is enough: how often a point is covered is the sum of the winding numbers of the
// borders around it, as all triangles count positively, and that is 1 at most.
bool isInjective(const Chart& chart, std::span<const Vec2> plane);

// Whether borders still do not cross, and turn the right way, on grids of 2⁻²⁰, some ten times as coarse as
// float texture coordinates of a surface of area 1. Narrow notches and holes may not: then the atlas would
// have to be packed again without the chart.
bool survivesRounding(const Chart& chart, std::span<const Vec2> plane);

}  // namespace bakelight::atlas
