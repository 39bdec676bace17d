// Sets of directions for quadrature over the sphere.
#pragma once

#include <span>
#include <vector>

#include "transport/vector_types.h"

namespace bakelight::transport {

// `count` directions of equal weight 4π/count: the spherical Fibonacci lattice (Marques et al. 2013), whose
// integration error for smooth functions falls faster than 1/count. Deterministic. Sorted along a
// space-filling curve of the octahedral map, so that neighbours in the list are neighbours on the sphere and
// rays along them stay coherent.
std::vector<Vec3> sphereDirections(int count);

// The largest angle between a direction of the upper hemisphere and the nearest of these (one or more), to 1°, and where
// it is.
struct DirectionGap {
  double angle_rad = 0;
  Vec3 direction = Vec3::UnitZ();
};
DirectionGap largestGap(std::span<const Vec3> directions);

}  // namespace bakelight::transport
