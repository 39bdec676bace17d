// Packs flat charts into a square.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "tools/atlas/charts/surface.h"

namespace bakelight::atlas {

// What a chart looks like: its triangles in the plane, counter-clockwise, not overlapping. All charts have
// one unit of length and keep their sizes relative to each other.
struct FlatChart {
  std::vector<Vec2> vertices;
  std::vector<Triangle> triangles;
};

struct PackingOptions {
  int resolution = 1024;  // texels, of the square's side, 16–16384
  int gutter = 2;         // texels, 0–64
  int border = 0;         // texels, 0–64: each chart is surrounded by so many texels that are its own, too
};

// texel = texels_per_unit · R(angle_rad) · vertex + offset, with the origin at the lower left of the square,
// in texels: texel (i, j) is the square [i, i+1] × [j, j+1].
struct Placement {
  double angle_rad = 0;
  Vec2 offset = Vec2::Zero();
};

struct Packing {
  double texels_per_unit = 0;  // one for all charts: the largest that was found to fit
  std::vector<Placement> placements;
};

// A texel is *touched* by a chart if the open texel and the chart, blown up by 1/64 texel (for the rounding
// of coordinates to float), overlap. Guarantees: touched texels lie inside the square, `border` texels from
// its sides at least, and between two texels touched by different charts there are at least `gutter` +
// 2·`border` free ones in row, column and diagonal: the larger of |Δi| and |Δj| is more than that.
// Deterministic; threads by TBB, the same result for any number of them. Cost: seconds at most; up to 128
// charts are nested by a search of bounded effort, more are placed once each. Throws Error(kBadInput) naming
// `file` if the charts do not fit at any scale: each takes one texel at least.
Packing pack(std::span<const FlatChart> charts, const PackingOptions& options, const std::string& file);

}  // namespace bakelight::atlas
