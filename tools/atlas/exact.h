// Predicates whose answers are exact for any coordinates. Behind them is CGAL, which no other file of this
// room includes.
#pragma once

#include "tools/atlas/charts/surface.h"

namespace bakelight::atlas {

// 1: a, b, c turn left, −1: right, 0: they lie on one line.
int orientation(const Vec2& a, const Vec2& b, const Vec2& c);

// Whether the segments ab and cd have a point in common that is not an end of both. So neighbours along a
// border do not cross, unless one folds back onto the other.
bool segmentsCross(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d);

}  // namespace bakelight::atlas
