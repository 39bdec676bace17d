// What the light on a patch is a sum of.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "transport/vector_types.h"

namespace bakelight::rtt {

using transport::Vec3;

// 2π/side²
double cellSolidAngle(int side);

// Functions of the direction that light comes from: spherical harmonics, or of each cell of the hemisphere's grid what
// is 1 ÷ its solid angle in it and 0 beside it, whose coefficient is radiance × solid angle.
class LightBasis {
 public:
  static LightBasis sphericalHarmonics(int order);
  static LightBasis cells(int side);

  std::size_t count() const;

  struct Values {
    std::size_t first;            // function
    std::span<const float> some;  // from there on; all others are 0
  };
  // `direction` is unit, z > 0. Valid until `room` is used again.
  struct Room {
    std::vector<double> harmonics;
    std::vector<float> values;
  };
  Values at(const Vec3& direction, Room& room) const;

 private:
  LightBasis(int order, int side) : order_(order), side_(side) {}
  int order_, side_;  // one of them is 0
};

}  // namespace bakelight::rtt
