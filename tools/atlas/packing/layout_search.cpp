#include "tools/atlas/packing/layout_search.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "tools/atlas/packing/separation.h"
#include "tools/atlas/packing/turned_masks.h"

namespace bakelight::atlas {
namespace {

constexpr std::size_t kStarts = 8, kFinalists = 4;

// Rows of texels that are compared by one start: enough for some twenty charts; with many, bringing them
// apart texel by texel takes more, and finding a place for each does not: small ones fill the gaps.
struct Effort {
  std::int64_t coarse, medium, fine;
};
Effort effortFor(std::size_t charts) {
  const double few = std::min(1.0, static_cast<double>(charts) / 16);
  const double many = std::max(1.0, static_cast<double>(charts) / 50);
  const double fill_gaps = std::min(1.0, 40 / static_cast<double>(charts));
  return {std::llround(few * fill_gaps * 4e7), std::llround(few * many * 8e6),
          std::llround(few * many * 3e7)};
}

// The square as cells of some texels each.
struct Level {
  int side = 0;
  CellGrowth growth;
  int turns = 0;
};

struct Layout {
  std::vector<Spot> spots;
  double density = 0;  // texels per unit ÷ texels of the square's side
};

// Charts reach half the distance around themselves, so they may reach as far out of the square.
int sideWithReach(const PackingSquare& square) {
  return square.side - 2 * square.margin + square.distance;
}

// Cells larger than texels: a chart with its half of the distance has those whose middles it covers.
Level levelOfCells(const PackingSquare& square, int side, int turns) {
  const int texels = sideWithReach(square), cells = std::min(side, texels);
  const double reach = (square.distance / 2.0 + 0.5 + kBlowUp) * cells / texels - 0.5;
  return {cells, {reach, reach}, turns};
}

// Texels themselves. Masks with the distance at their left and below keep apart as if each had half of it on
// all sides.
Level levelOfTexels(const PackingSquare& square) {
  return {sideWithReach(square), {kBlowUp, kBlowUp + square.distance}, 1024};
}

// The share of the square that charts fill, of which the search begins, and that for which the cells are
// made.
constexpr double kFirstShare = 0.7, kTargetShare = 0.82;

// From nothing: charts keep their size in cells, and the square shrinks under them. Where that fails two
// charts change places, and the search goes on.
Layout explored(TurnedMasks& masks, int side, std::span<const std::uint32_t> order, std::int64_t work_limit,
                std::uint64_t seed) {
  const Separation::Moves moves{.turns = {0, 1, -1, 3, -3}, .reach = side, .random_lines = 8};
  Separation separation(masks, side, seed);
  while (!separation.placeAll(order, 24)) separation.setSide(side += 1 + side / 8);
  std::optional<Layout> best;
  while (separation.work() < work_limit) {
    if (separation.separate(moves, 100, work_limit)) {
      best = {separation.spots(), masks.texelsPerUnit() / side};
      if (!separation.setSide(side - 1)) break;
      --side;
    } else if (best) {
      separation.placeAt(best->spots);
      const std::uint64_t larger_half = order.size() / 2 + 1;
      separation.swapPlaces(order[separation.random(larger_half)], order[separation.random(larger_half)]);
    } else {
      separation.setSide(side += 1 + side / 32);
    }
  }
  return best.value_or(Layout{separation.spots(), masks.texelsPerUnit() / side});
}

// From a layout of larger cells, which overlap a little in these; until the square does not shrink further.
Layout tightened(std::span<const ChartOutline> outlines, const Level& level, const Layout& start,
                 std::int64_t work_limit, std::uint64_t seed) {
  const Separation::Moves moves{.turns = {0, 1, -1, 4, -4}, .reach = level.side / 16, .random_lines = 2};
  TurnedMasks masks(outlines, level.side * start.density, level.growth, level.turns);
  int side = level.side + level.side / 128;
  Separation separation(masks, side, seed);
  if (!separation.placeAt(start.spots)) return start;
  std::optional<Layout> best;
  while (separation.work() < work_limit) {
    if (separation.separate(moves, 60, work_limit)) {
      best = {separation.spots(), masks.texelsPerUnit() / side};
      if (!separation.setSide(side - 1)) break;
      --side;
    } else if (best) {
      break;
    } else {
      separation.setSide(side += 1 + side / 32);
    }
  }
  return best.value_or(start);
}

// In texels: the charts grow as long as they can be kept apart, in the end by one part in 5,000. Nothing if
// they still overlap at a fifth less than the layout's scale.
std::optional<Packing> grown(std::span<const ChartOutline> outlines, const PackingSquare& square,
                             const Layout& start, std::int64_t work_limit, std::uint64_t seed) {
  const Level level = levelOfTexels(square);
  const Separation::Moves moves{.turns = {0, 1, -1, 5, -5}, .reach = level.side / 32, .random_lines = 1};
  std::optional<Packing> best;
  Layout layout = start;
  std::int64_t work = 0;
  double step = 0.004;
  for (double density = start.density; work < work_limit && step > 0.0002 && density > 0.8 * start.density;) {
    TurnedMasks masks(outlines, density * level.side, level.growth, level.turns);
    Separation separation(masks, level.side, ++seed);
    const bool done = separation.placeAt(layout.spots) && separation.separate(moves, 12, work_limit - work);
    work += 1 + separation.work();
    if (done) {
      layout = {separation.spots(), density};
      best = Packing{masks.texelsPerUnit(), {}};
      for (std::size_t i = 0; i < outlines.size(); ++i) {
        Placement placement = separation.placementOf(i);
        placement.offset.array() += square.margin - square.distance;
        best->placements.push_back(placement);
      }
    } else if (best) {
      step /= 2;
    }
    density = best ? layout.density * (1 + step) : density * 0.985;
  }
  return best;
}

}  // namespace

double greatestDensity(std::span<const ChartOutline> outlines) {
  double area = 0, longest = 0;
  for (const ChartOutline& outline : outlines) {
    area += outline.area;
    const auto [low, high] = turnedBox(outline.hull, 0);
    longest = std::max(longest, (high - low).norm());
  }
  // The box's diagonal is up to √2 times the chart's length, which is up to √2 times the square's side.
  return std::min(1 / std::sqrt(area), 2 / longest);
}

std::optional<Packing> searchedPacking(std::span<const ChartOutline> outlines,
                                       std::span<const std::uint32_t> order, const PackingSquare& square) {
  const Effort effort = effortFor(outlines.size());
  const Level coarse = levelOfCells(square, 128, 64), medium = levelOfCells(square, 384, 256);
  TurnedMasks masks(outlines, coarse.side * std::sqrt(kTargetShare) * greatestDensity(outlines),
                    coarse.growth, coarse.turns);
  masks.makeAll();
  const int first_side = static_cast<int>(std::ceil(coarse.side * std::sqrt(kTargetShare / kFirstShare)));

  std::array<Layout, kStarts> starts;
  tbb::parallel_for(std::size_t{0}, kStarts,
                    [&](std::size_t i) { starts[i] = explored(masks, first_side, order, effort.coarse, i); });
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Layout& a, const Layout& b) { return a.density > b.density; });
  std::array<std::optional<Packing>, kFinalists> packings;
  tbb::parallel_for(std::size_t{0}, kFinalists, [&](std::size_t i) {
    const Layout layout = tightened(outlines, medium, starts[i], effort.medium, i);
    packings[i] = grown(outlines, square, layout, effort.fine, 1000 * i);
  });
  const auto scale = [](const std::optional<Packing>& packing) {
    return packing ? packing->texels_per_unit : 0;
  };
  return *std::max_element(packings.begin(), packings.end(),
                           [&](const auto& a, const auto& b) { return scale(a) < scale(b); });
}

}  // namespace bakelight::atlas
