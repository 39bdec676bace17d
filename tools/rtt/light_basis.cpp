#include "tools/rtt/light_basis.h"

#include <algorithm>
#include <numbers>

#include "transport/hemisphere_grid.h"
#include "transport/sh.h"

namespace bakelight::rtt {

double cellSolidAngle(int side) {
  return 2 * std::numbers::pi / side / side;
}

LightBasis LightBasis::sphericalHarmonics(int order) {
  return {order, 0};
}

LightBasis LightBasis::cells(int side) {
  return {0, side};
}

std::size_t LightBasis::count() const {
  const auto root = static_cast<std::size_t>(order_) + static_cast<std::size_t>(side_);
  return root * root;
}

LightBasis::Values LightBasis::at(const Vec3& direction, Room& room) const {
  if (side_ > 0) {
    const transport::SquarePoint point = transport::squareFromHemisphere(direction);
    const auto cell = [this](double place) {
      return std::clamp(static_cast<int>(place * side_), 0, side_ - 1);
    };
    room.values.assign(1, static_cast<float>(1 / cellSolidAngle(side_)));
    return {static_cast<std::size_t>(cell(point.b)) * side_ + cell(point.a), room.values};
  }
  room.harmonics.resize(count()), room.values.resize(count());
  transport::evaluateSh(order_, direction, room.harmonics);
  std::ranges::transform(room.harmonics, room.values.begin(), [](double y) { return static_cast<float>(y); });
  return {0, room.values};
}

}  // namespace bakelight::rtt
