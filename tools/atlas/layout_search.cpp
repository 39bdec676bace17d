#include "tools/atlas/layout_search.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "tools/atlas/separation.h"
#include "tools/atlas/turned_masks.h"

namespace bakelight::atlas {
namespace {

// Effort: rows of texels compared, by one start.
constexpr std::int64_t kCoarseWork = 40'000'000, kFineWork = 30'000'000;
constexpr std::size_t kStarts = 4, kFinalists = 2;

constexpr int kCoarseSide = 128, kCoarseTurns = 64, kFineTurns = 1024;

struct Layout {
  std::vector<Spot> spots;
  double density = 0;  // texels per unit ÷ texels of the square's side
};

// Charts reach half the distance around themselves, so they may reach as far out of the square.
int sideWithReach(const PackingSquare& square) {
  return square.side - 2 * square.margin + square.distance;
}

double totalArea(std::span<const ChartOutline> outlines) {
  double area = 0;
  for (const ChartOutline& outline : outlines) area += outline.area;
  return area;
}

// Cells that are much larger than texels: a chart with its share of the distance has those whose middles it
// covers. The charts keep their size in cells, and the square shrinks.
Layout coarseLayout(std::span<const ChartOutline> outlines, std::span<const std::uint32_t> order,
                    const PackingSquare& square, std::uint64_t seed) {
  constexpr double kTarget = 0.82, kFirst = 0.7;  // shares of the square that charts fill
  const int fine_side = sideWithReach(square);
  const int target_side = std::min(kCoarseSide, fine_side);
  const double texels_a_cell = static_cast<double>(fine_side) / target_side;
  const double reach = (square.distance / 2.0 + 0.5 + kBlowUp) / texels_a_cell - 0.5;
  const double cells_per_unit = target_side * std::sqrt(kTarget / totalArea(outlines));

  TurnedMasks masks(outlines, cells_per_unit, {reach, reach}, kCoarseTurns);
  int side = static_cast<int>(std::ceil(target_side * std::sqrt(kTarget / kFirst)));
  Separation separation(masks, side, seed);
  while (!separation.placeAll(order, 24)) separation.setSide(side += 1 + side / 8);
  const Separation::Moves moves{{0, 1, -1, 3, -3}, 2 * kCoarseSide, 8};
  std::optional<Layout> best;
  while (separation.work() < kCoarseWork) {
    if (separation.separate(moves, 30, kCoarseWork)) {
      best = {separation.spots(), cells_per_unit / side};
      if (!separation.setSide(side - 1)) break;
      --side;
    } else if (!best) {
      separation.setSide(side += 1 + side / 32);
    } else {
      const std::uint64_t larger_half = order.size() / 2 + 1;
      separation.swapPlaces(order[separation.random(larger_half)], order[separation.random(larger_half)]);
    }
  }
  return best.value_or(Layout{separation.spots(), cells_per_unit / side});
}

// The charts grow as long as they can be kept apart, in the end by one part in 5,000.
std::optional<Packing> grown(std::span<const ChartOutline> outlines, const PackingSquare& square,
                             const Layout& start, std::uint64_t seed) {
  const int side = sideWithReach(square);
  // Masks with the distance at their left and below keep apart as if each had half of it on all sides.
  const CellGrowth growth{kBlowUp, kBlowUp + square.distance};
  const Separation::Moves moves{{0, 1, -1, 5, -5}, side / 32, 1};
  std::optional<Packing> best;
  Layout layout = start;
  std::int64_t work = 0;
  double step = 0.004;
  for (double density = start.density; work < kFineWork && step > 0.0002;) {
    const double texels_per_unit = density * side;
    TurnedMasks masks(outlines, texels_per_unit, growth, kFineTurns);
    Separation separation(masks, side, ++seed);
    const bool done = separation.placeAt(layout.spots) && separation.separate(moves, 12, kFineWork - work);
    work += separation.work();
    if (done) {
      layout = {separation.spots(), density};
      best = Packing{texels_per_unit, {}};
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

std::optional<Packing> searchedPacking(std::span<const ChartOutline> outlines,
                                       std::span<const std::uint32_t> order, const PackingSquare& square) {
  std::array<Layout, kStarts> starts;
  tbb::parallel_for(std::size_t{0}, kStarts,
                    [&](std::size_t i) { starts[i] = coarseLayout(outlines, order, square, i); });
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Layout& a, const Layout& b) { return a.density > b.density; });
  std::array<std::optional<Packing>, kFinalists> packings;
  tbb::parallel_for(std::size_t{0}, kFinalists,
                    [&](std::size_t i) { packings[i] = grown(outlines, square, starts[i], 1000 * i); });
  const auto scale = [](const std::optional<Packing>& packing) {
    return packing ? packing->texels_per_unit : 0;
  };
  return *std::max_element(packings.begin(), packings.end(),
                           [&](const auto& a, const auto& b) { return scale(a) < scale(b); });
}

}  // namespace bakelight::atlas
