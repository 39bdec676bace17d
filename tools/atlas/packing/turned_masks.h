// Masks of charts in any of a number of turns.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "tools/atlas/packing/texel_mask.h"

namespace bakelight::atlas {

struct TurnedMask {
  double angle_rad = 0;
  Vec2 offset = Vec2::Zero();  // the placement's, if the mask's box begins at (0, 0)
  Vec2 middle = Vec2::Zero();  // of the chart's box before it was turned, if the mask's box begins at (0, 0)
  TexelMask rows;
  TexelMask columns;  // the same texels mirrored, (j, i) for (i, j)
};

// Masks are made when they are first asked for: threads can share this only after makeAll(). `outlines` must
// outlive it.
class TurnedMasks {
 public:
  // Turn t of a chart is its upright one and t / `turns` of a full circle more.
  TurnedMasks(std::span<const ChartOutline> outlines, double texels_per_unit, const CellGrowth& growth,
              int turns);

  void makeAll();  // threads by TBB
  const TurnedMask& at(std::size_t chart, int turn);
  int turns() const { return turns_; }
  std::size_t charts() const { return outlines_.size(); }
  double texelsPerUnit() const { return texels_per_unit_; }

 private:
  std::span<const ChartOutline> outlines_;
  double texels_per_unit_;
  CellGrowth growth_;
  int turns_;
  std::vector<std::unique_ptr<TurnedMask>> masks_;  // charts × turns
};

}  // namespace bakelight::atlas
