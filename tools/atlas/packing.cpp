#include "tools/atlas/packing.h"

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
#include "tools/atlas/chart_outline.h"
#include "tools/atlas/occupancy.h"
#include "tools/atlas/texel_mask.h"

namespace bakelight::atlas {
namespace {

// Boxes of so many texels a side are placed as boxes: what they do not fill is less than the gutter takes.
constexpr int kBoxedSide = 6;

// The square that is filled, which may be coarser than the one asked for.
struct Grid {
  int side = 0;      // texels
  int distance = 0;  // free texels between charts
  int margin = 0;    // free texels at the square's sides

  // How many charts of one texel have room in a row of them.
  std::int64_t texelsInARow() const { return std::max(0, (side - 2 * margin + distance) / (1 + distance)); }
};

void requireRoom(std::size_t charts, const Grid& grid, const PackingOptions& options,
                 const std::string& file) {
  const std::int64_t places = grid.texelsInARow() * grid.texelsInARow();
  if (static_cast<std::int64_t>(charts) <= places) return;
  const auto in_a_row = static_cast<std::int64_t>(std::ceil(std::sqrt(static_cast<double>(charts))));
  const std::int64_t cell = 1 + grid.distance;
  const std::int64_t needed = in_a_row * cell - grid.distance + 2 * grid.margin;
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
  explicit Filling(const Grid& grid) : grid_(grid), occupancy_(grid.side) {}

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
      const int end = std::min(grid_.side - grid_.margin - mask.height + 1,
                               best ? best->top() - mask.height : grid_.side);
      for (int y = grid_.margin; y < end; ++y)
        if (const auto x = occupancy_.firstFree(mask, y, grid_.margin)) {
          best = {std::move(turned), *x, y};
          break;
        }
    }
    if (best) occupancy_.take(dilated(best->chart.mask, grid_.distance), best->x, best->y);
    return best;
  }

 private:
  // Places only ever get taken: so a box of one size never finds one below the last.
  std::optional<Placed> placeBox(TurnedChart turned) {
    const int width = turned.mask.width, height = turned.mask.height;
    TexelMask box;
    box.width = width, box.height = height;
    box.row_begins.resize(height + 1);
    std::iota(box.row_begins.begin(), box.row_begins.end(), 0u);
    box.spans.assign(height, {0, width});
    int& y = cursors_.try_emplace({width, height}, grid_.margin).first->second;
    for (; y + height <= grid_.side - grid_.margin; ++y)
      if (const auto x = occupancy_.firstFree(box, y, grid_.margin)) return Placed{std::move(turned), *x, y};
    return std::nullopt;
  }

  Grid grid_;
  Occupancy occupancy_;
  std::map<std::pair<int, int>, int> cursors_;
};

std::optional<std::vector<Placement>> placedAtScale(const std::vector<ChartOutline>& outlines,
                                                    const std::vector<std::uint32_t>& order, const Grid& grid,
                                                    double texels_per_unit) {
  Filling filling(grid);
  std::vector<Placement> placements(outlines.size());
  for (const std::uint32_t i : order) {
    std::array<double, 4> angles{};
    for (std::size_t k = 0; k < 4; ++k)
      angles[k] = outlines[i].upright_angle_rad + static_cast<double>(k) * std::numbers::pi / 2;
    const auto placed = filling.place(outlines[i], texels_per_unit, angles);
    if (!placed) return std::nullopt;
    placements[i] = {placed->chart.angle_rad, placed->chart.offset + Vec2(placed->x, placed->y)};
  }
  return placements;
}

}  // namespace

Packing pack(std::span<const FlatChart> charts, const PackingOptions& options, const std::string& file) {
  const Grid grid{options.resolution, options.gutter + 2 * options.border, options.border};
  requireRoom(charts.size(), grid, options, file);
  if (charts.empty()) return {1, {}};

  std::vector<ChartOutline> outlines(charts.size());
  std::transform(charts.begin(), charts.end(), outlines.begin(), outlineOf);
  std::vector<std::uint32_t> order(charts.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return outlines[a].area > outlines[b].area; });

  double area = 0, longest = 0;
  for (const ChartOutline& outline : outlines) {
    area += outline.area;
    const auto [low, high] = turnedBox(outline.hull, 0);
    longest = std::max(longest, (high - low).norm());
  }
  // At the lower scale each chart takes one texel, so all fit; at the upper their areas fill the square.
  double low = 0.9 / longest, high = std::max(grid.side / std::sqrt(area), 1.01 * low);
  auto best = placedAtScale(outlines, order, grid, low);
  if (!best) throw std::logic_error("pack: charts of one texel each have no room");
  while (high > 1.003 * low) {
    const double middle = std::sqrt(low * high);
    if (auto placements = placedAtScale(outlines, order, grid, middle)) {
      best = std::move(placements);
      low = middle;
    } else {
      high = middle;
    }
  }
  return {low, std::move(*best)};
}

}  // namespace bakelight::atlas
