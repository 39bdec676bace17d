// From a surface to charts that lie flat, one-to-one and with little distortion.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/atlas/chart.h"
#include "tools/atlas/stretch.h"

namespace bakelight::atlas {

struct FlatPiece {
  Chart chart;
  std::vector<Vec2> plane;  // of the chart's vertices, counter-clockwise
  StretchSum stretch;
};

struct ChartingOptions {
  double max_stretch = 1.03;  // L² stretch of each chart
  double pieces = 60;      // to begin with
  double roundness = 3;       // largest perimeter² ÷ (4π area) that merging may make
  double solidity = 0.85;     // least area ÷ convex hull that merging may make
  double largest_share = 0.1;  // of the whole area, that merging may make
};

struct ChartingReport {
  std::int64_t regions = 0, first_pieces = 0, splits = 0, merges = 0, merges_tried = 0;
};

std::vector<FlatPiece> makeCharts(const Surface& surface, const ChartingOptions& options, ChartingReport& report);

}  // namespace bakelight::atlas
