// Which chart each texel belongs to, and how much of the surface lies in it.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/atlas/atlas.h"

namespace bakelight::atlas {

// Texel (i, j), counted from the lower left, at j · resolution + i.
struct TexelCover {
  std::vector<double> areas;                   // of the surface in the texel, of all charts
  std::vector<std::int32_t> center_triangles;  // that have the texel's centre; −1: none; the first of several
  // The chart of that triangle; else the one with the largest area in the texel, of equal ones the first;
  // −1: none.
  std::vector<std::int32_t> charts;
};

// Areas are those of triangles cut along the lines between texels, so that they add up to the surface's, but
// for rounding and for triangles without an area in the plane, which are left out. Coordinates must lie in
// the unit square. Cost: O(triangles + texels that they touch); threads by TBB, same bits for any number.
TexelCover coverTexels(const Atlas& atlas, int resolution);

}  // namespace bakelight::atlas
