// Scatter plots of error against a cost, as SVG, with the Pareto front as a stepped line.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace bakelight::report {

// Colours (classes g0 …, see page_style.cpp) and shapes that can be told apart, in print without colours too.
inline constexpr std::size_t kMarkers = 7;

// SVG of a marker around (x, y).
std::string markerSvg(std::size_t marker, double x, double y, bool filled);

struct PlotPoint {
  std::string name;   // of the variant: data-variant
  std::string label;  // beside points of the front
  std::string title;  // shown where a pointer rests on it
  double cost = 0, error = 0;
  double cost_low = 0, cost_high = 0;  // whiskers; both equal to cost without
  std::size_t marker = 0;              // < kMarkers
};

struct Plot {
  std::string title, cost_label, error_label;
  std::function<std::string(double)> cost_text, error_text;  // of a tick
  std::vector<PlotPoint> points;
  std::vector<std::size_t> front;  // indices of points, by rising cost
};

// As wide as its box, 360 units across, which is a phone's width in pixels. Labels keep clear of each other
// and of points; the last resort for one that has no room is to be left out.
std::string plotSvg(const Plot& plot);

}  // namespace bakelight::report
