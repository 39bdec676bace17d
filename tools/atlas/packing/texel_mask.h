// The texels that a placed chart touches, as spans of rows.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/atlas/charts/chart_outline.h"

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

// By how much the cell of a texel is larger than the texel: the cell of (i, j) is the open square from i −
// low, j − low to i + 1 + high, j + 1 + high. May be negative, above −1/2.
struct CellGrowth {
  double low = 0, high = 0;
};

// What touching a texel means in packing.h, with a square of half a side of 1/64 for the disk.
inline constexpr double kBlowUp = 1.0 / 64;
inline constexpr CellGrowth kTouched{kBlowUp, kBlowUp};

// The texels whose cells overlap the chart with its vertices at `points`. With kTouched grown by n texels
// these are the touched ones and those up to n texels from them. Cost: O(edges' rows).
TexelMask texelsOf(const ChartOutline& outline, const std::vector<Vec2>& points, const CellGrowth& growth);

std::vector<Vec2> placedVertices(const ChartOutline& outline, double texels_per_unit,
                                 const Placement& placement);

// A chart of one size in one turn, where its mask's box begins at texel (0, 0).
struct TurnedChart {
  double angle_rad = 0;
  Vec2 offset = Vec2::Zero();  // the placement's
  TexelMask mask;

  Placement at(int x, int y) const { return {angle_rad, offset + Vec2(x, y)}; }
};

// The chart lies in the middle of as few rows and columns of cells as it can overlap.
TurnedChart turnedChart(const ChartOutline& outline, double texels_per_unit, double angle_rad,
                        const CellGrowth& growth = kTouched);

}  // namespace bakelight::atlas
