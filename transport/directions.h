// Sets of directions for quadrature over the sphere.
#pragma once

#include <vector>

#include "transport/vector_types.h"

namespace bakelight::transport {

// `count` directions of equal weight 4π/count: the spherical Fibonacci lattice (Marques et al. 2013), whose
// integration error for smooth functions falls faster than 1/count. Deterministic. Sorted along a
// space-filling curve of the octahedral map, so that neighbours in the list are neighbours on the sphere and
// rays along them stay coherent.
std::vector<Vec3> sphereDirections(int count);

}  // namespace bakelight::transport
