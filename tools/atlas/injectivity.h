// Whether a flat chart is one-to-one, judged exactly.
#pragma once

#include <cstdint>
#include <span>

#include "tools/atlas/chart.h"

namespace bakelight::atlas {

// Triangles whose orientation in the plane is not positive.
std::int64_t flippedTriangles(const Chart& chart, std::span<const Vec2> plane);

// Whether two edges of the chart's borders cross or overlap (segmentsCross).
bool bordersCross(const Chart& chart, std::span<const Vec2> plane);

// No triangle is flipped or collapsed, and no border crosses itself or another one. For a disk with holes
// that is enough: how often a point is covered is the winding number of the borders around it, which is 0 or
// 1 if they are simple, and all triangles count positively.
bool isInjective(const Chart& chart, std::span<const Vec2> plane);

}  // namespace bakelight::atlas
