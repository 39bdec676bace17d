#include "tools/atlas/packing/packing.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

#include "formats/error.h"
#include "tools/atlas/charts/chart_outline.h"
#include "tools/atlas/packing/layout_search.h"
#include "tools/atlas/packing/occupancy.h"
#include "tools/atlas/packing/texel_mask.h"

namespace bakelight::atlas {
namespace {

// Boxes of so many texels a side are placed as boxes: what they do not fill is less than the gutter takes.
constexpr int kBoxedSide = 6;

// Of texels that are `factor` of those asked for wide.
PackingSquare squareOf(const PackingOptions& options, int factor) {
  const auto up = [&](int texels) { return (texels + factor - 1) / factor; };
  return {options.resolution / factor, up(options.gutter + 2 * options.border), up(options.border)};
}

// How many charts of one texel have room in a row of them.
std::int64_t texelsInARow(const PackingSquare& square) {
  return std::max(0, (square.side - 2 * square.margin + square.distance) / (1 + square.distance));
}

void requireRoom(std::size_t charts, const PackingSquare& square, const PackingOptions& options,
                 const std::string& file) {
  const std::int64_t places = texelsInARow(square) * texelsInARow(square);
  if (static_cast<std::int64_t>(charts) <= places) return;
  const auto in_a_row = static_cast<std::int64_t>(std::ceil(std::sqrt(static_cast<double>(charts))));
  const std::int64_t cell = 1 + square.distance;
  const std::int64_t needed = in_a_row * cell - square.distance + 2 * square.margin;
  throw badInput({file, "atlas", ""},
                 std::to_string(charts) + " charts do not fit into " + std::to_string(options.resolution) +
                     "² texels: each takes " + std::to_string(cell * cell) +
                     " at least, one of its own and a gutter of " + std::to_string(options.gutter) +
                     (options.border > 0 ? " and borders of " + std::to_string(options.border) : "") +
                     ", so " + std::to_string(places) + " have room",
                 "a resolution of " + std::to_string(needed) + " or more",
                 "raise the resolution, lower the gutter, or make fewer charts");
}

struct Placed {
  TurnedChart chart;
  int x = 0, y = 0;
  int top() const { return y + chart.mask.height; }
};

// Fills the square from below, chart by chart.
class Filling {
 public:
  explicit Filling(const PackingSquare& square) : square_(square), occupancy_(square.side) {}

  // The lowest place of the chart in the given turns, by its upper end.
  std::optional<Placed> place(const ChartOutline& outline, double texels_per_unit,
                              std::span<const double> angles_rad) {
    std::optional<Placed> best;
    for (const double angle : angles_rad) {
      TurnedChart turned = turnedChart(outline, texels_per_unit, angle);
      const TexelMask& mask = turned.mask;
      if (std::max(mask.width, mask.height) <= kBoxedSide) {
        best = placeBox(std::move(turned));
        break;
      }
      const int end = std::min(square_.side - square_.margin - mask.height + 1,
                               best ? best->top() - mask.height : square_.side);
      // Where one of about the same size found no place, this hardly will.
      int& lowest = cursors_.try_emplace(sizeClass(mask), square_.margin).first->second;
      for (int y = lowest; y < end; ++y)
        if (const auto x = occupancy_.firstFree(mask, y, square_.margin)) {
          lowest = y;
          best = {std::move(turned), *x, y};
          break;
        }
    }
    if (best) {
      const double reach = kBlowUp + square_.distance;
      const auto vertices = placedVertices(outline, texels_per_unit, best->chart.at(0, 0));
      occupancy_.take(texelsOf(outline, vertices, {reach, reach}), best->x, best->y);
    }
    return best;
  }

 private:
  static std::pair<int, int> sizeClass(const TexelMask& mask) {
    const auto classOf = [](int side) { return kBoxedSide + static_cast<int>(8 * std::log2(side)); };
    return {classOf(mask.width), classOf(mask.height)};
  }

  // Places only ever get taken: so a box of one size never finds one below the last.
  std::optional<Placed> placeBox(TurnedChart turned) {
    const int width = turned.mask.width, height = turned.mask.height;
    TexelMask box;
    box.width = width, box.height = height;
    box.row_begins.resize(height + 1);
    std::iota(box.row_begins.begin(), box.row_begins.end(), 0u);
    box.spans.assign(height, {0, width});
    int& y = cursors_.try_emplace({width, height}, square_.margin).first->second;
    for (; y + height <= square_.side - square_.margin; ++y)
      if (const auto x = occupancy_.firstFree(box, y, square_.margin))
        return Placed{std::move(turned), *x, y};
    return std::nullopt;
  }

  PackingSquare square_;
  Occupancy occupancy_;
  std::map<std::pair<int, int>, int> cursors_;  // of boxes by their size, of others by its class
};

std::optional<std::vector<Placement>> placedAtScale(const std::vector<ChartOutline>& outlines,
                                                    const std::vector<std::uint32_t>& order,
                                                    const PackingSquare& square, double texels_per_unit) {
  Filling filling(square);
  std::vector<Placement> placements(outlines.size());
  for (const std::uint32_t i : order) {
    std::array<double, 4> angles{};
    for (std::size_t k = 0; k < 4; ++k)
      angles[k] = outlines[i].upright_angle_rad + static_cast<double>(k) * std::numbers::pi / 2;
    const auto placed = filling.place(outlines[i], texels_per_unit, angles);
    if (!placed) return std::nullopt;
    placements[i] = placed->chart.at(placed->x, placed->y);
  }
  return placements;
}

// A square of fewer texels where those asked for are finer than helps: but charts must stay much larger than
// a texel. What keeps the distance there keeps it in the finer one.
int coarsening(std::size_t charts, const PackingOptions& options) {
  constexpr int kFineEnough = 1024;
  int factor = (options.resolution + kFineEnough - 1) / kFineEnough;
  const auto roomy = [&] {
    const std::int64_t row = texelsInARow(squareOf(options, factor));
    return row * row >= 9 * static_cast<std::int64_t>(charts);
  };
  while (factor > 1 && !roomy()) --factor;
  return factor;
}

// The largest scale at which charts of the given order can be placed from below.
Packing filledPacking(const std::vector<ChartOutline>& outlines, const std::vector<std::uint32_t>& order,
                      const PackingSquare& square) {
  double longest = 0;
  for (const ChartOutline& outline : outlines) {
    const auto [lower_left, upper_right] = turnedBox(outline.hull, 0);
    longest = std::max(longest, (upper_right - lower_left).norm());
  }
  // At the lower scale each chart takes one texel, so all fit.
  double low = 0.9 / longest, high = std::max(square.side * greatestDensity(outlines), 1.01 * low);
  auto best = placedAtScale(outlines, order, square, low);
  if (!best) throw std::logic_error("pack: charts of one texel each have no room");
  while (high > 1.003 * low) {
    const double middle = std::sqrt(low * high);
    if (auto placements = placedAtScale(outlines, order, square, middle)) {
      best = std::move(placements);
      low = middle;
    } else {
      high = middle;
    }
  }
  return {low, std::move(*best)};
}

}  // namespace

Packing pack(std::span<const FlatChart> charts, const PackingOptions& options, const std::string& file) {
  requireRoom(charts.size(), squareOf(options, 1), options, file);
  if (charts.empty()) return {1, {}};

  std::vector<ChartOutline> outlines(charts.size());
  tbb::parallel_for(std::size_t{0}, charts.size(),
                    [&](std::size_t i) { outlines[i] = outlineOf(charts[i]); });
  std::vector<std::uint32_t> order(charts.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return outlines[a].area > outlines[b].area; });

  const int factor = coarsening(charts.size(), options);
  const PackingSquare square = squareOf(options, factor);
  std::optional<Packing> packing;
  if (charts.size() <= kMostChartsSearched) packing = searchedPacking(outlines, order, square);
  if (!packing) packing = filledPacking(outlines, order, square);
  packing->texels_per_unit *= factor;
  for (Placement& placement : packing->placements) placement.offset *= factor;
  return *packing;
}

}  // namespace bakelight::atlas
