// Where borders of charts run into charts.
#pragma once

#include <cstdint>
#include <span>

#include "tools/atlas/charts/surface.h"

namespace bakelight::atlas {

// An edge along the border of a chart, from one corner of its triangle to the next.
struct BorderSegment {
  Vec2 from, to;
  int inner_side;  // of the triangle: 1 left, −1 right, 0 if it has no area
};

// Exact: whether the two cross in a point inside both, an end of one lies inside the other which goes on into
// the other's chart, or they run along each other with their charts on one side. Charts that only abut, along
// an edge or in a point, do not cross.
bool bordersCross(const BorderSegment& a, const BorderSegment& b);

// Pairs that cross; counting ends at `most`. Segments must have finite coordinates about the unit square.
// Cost: O(n log n) for borders that seldom meet.
std::int64_t countCrossings(std::span<const BorderSegment> borders, std::int64_t most);

}  // namespace bakelight::atlas
