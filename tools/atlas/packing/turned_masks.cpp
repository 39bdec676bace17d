#include "tools/atlas/packing/turned_masks.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <numbers>
#include <utility>

namespace bakelight::atlas {

TurnedMasks::TurnedMasks(std::span<const ChartOutline> outlines, double texels_per_unit,
                         const CellGrowth& growth, int turns)
    : outlines_(outlines),
      texels_per_unit_(texels_per_unit),
      growth_(growth),
      turns_(turns),
      masks_(outlines.size() * static_cast<std::size_t>(turns)) {}

void TurnedMasks::makeAll() {
  tbb::parallel_for(std::size_t{0}, outlines_.size(), [&](std::size_t chart) {
    for (int turn = 0; turn < turns_; ++turn) at(chart, turn);
  });
}

const TurnedMask& TurnedMasks::at(std::size_t chart, int turn) {
  std::unique_ptr<TurnedMask>& entry = masks_[chart * static_cast<std::size_t>(turns_) + turn];
  if (entry) return *entry;
  const ChartOutline& outline = outlines_[chart];
  const double angle = outline.upright_angle_rad + 2 * std::numbers::pi * turn / turns_;
  TurnedChart turned = turnedChart(outline, texels_per_unit_, angle, growth_);
  auto mask = std::make_unique<TurnedMask>();
  mask->angle_rad = angle;
  mask->offset = turned.offset;
  const auto [low, high] = turnedBox(outline.hull, 0);
  const Vec2 middle = texels_per_unit_ / 2 * (low + high);
  const double c = std::cos(angle), s = std::sin(angle);
  mask->middle = turned.offset + Vec2(c * middle.x() - s * middle.y(), s * middle.x() + c * middle.y());
  std::vector<Vec2> vertices = placedVertices(outline, texels_per_unit_, turned.at(0, 0));
  for (Vec2& v : vertices) std::swap(v.x(), v.y());
  mask->columns = texelsOf(outline, vertices, growth_);
  mask->rows = std::move(turned.mask);
  entry = std::move(mask);
  return *entry;
}

}  // namespace bakelight::atlas
