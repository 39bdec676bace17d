// The texels that a placed chart touches, as spans of rows.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/atlas/chart_outline.h"

namespace bakelight::atlas {

struct Span {
  int begin = 0, end = 0;  // texels begin … end − 1
};

struct TexelMask {
  int left = 0, bottom = 0;  // of the box about all spans
  int width = 0, height = 0;
  std::vector<std::uint32_t> row_begins;  // height + 1: the spans of row bottom + r are row_begins[r] …
  std::vector<Span> spans;                // relative to `left`, ascending, with a free texel between at least

  std::int64_t texelCount() const;
};

// A chart of the size and in the turn at which it is placed, relative to its mask's box: at home if the box's
// lower left is texel (0, 0), so left = bottom = 0.
struct TurnedChart {
  double angle_rad = 0;
  Vec2 offset = Vec2::Zero();  // the placement's, for the box at (0, 0)
  TexelMask mask;
};

// The texels that the outline touches, conservatively: `packing.h` has the definition, with a square of half
// a side of 1/64 texel for the disk. Cost: O(edges' rows).
TexelMask touchedTexels(const ChartOutline& outline, double texels_per_unit, const Placement& placement);

// The chart lies in the middle of as few rows and columns of texels as it can touch.
TurnedChart turnedChart(const ChartOutline& outline, double texels_per_unit, double angle_rad);

// All texels (i, j) with max(|Δi|, |Δj|) ≤ radius from one of the mask.
TexelMask dilated(const TexelMask& mask, int radius);

}  // namespace bakelight::atlas
