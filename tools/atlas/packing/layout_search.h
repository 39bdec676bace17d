// Looks for a layout of charts that fills a square: first coarsely and from several starts, then texel by
// texel.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tools/atlas/charts/chart_outline.h"

namespace bakelight::atlas {

// The square that is filled.
struct PackingSquare {
  int side = 0;      // texels
  int distance = 0;  // free texels between charts
  int margin = 0;    // free texels along the square's sides
};

// Beyond so many charts the search costs more than it finds.
inline constexpr std::size_t kMostChartsSearched = 128;

// Texels per unit of length ÷ texels of a square's side that no packing of the charts exceeds: areas would be
// larger than the square, or a chart longer than its diagonal.
double greatestDensity(std::span<const ChartOutline> outlines);

// A packing, or nothing if none was found. `order` is that in which charts are first placed. The effort is
// bounded by the rows of texels that are compared, so that the result depends on the input only. Threads by
// TBB.
std::optional<Packing> searchedPacking(std::span<const ChartOutline> outlines,
                                       std::span<const std::uint32_t> order, const PackingSquare& square);

}  // namespace bakelight::atlas
