// The directional lights that a patch is seen under.
#pragma once

#include <cstddef>
#include <vector>

#include "formats/words.h"
#include "transport/vector_types.h"

namespace bakelight::rtt {

using transport::Vec3;

enum class LightRule {
  kGaussLegendre,  // in z from 0 to 1: exact for spherical harmonics on a flat patch
  kPolar           // middles of equal steps of the polar angle, weighed by its sine: the paper's
};
inline constexpr formats::Word<LightRule> kLightRules[] = {{"gauss_legendre", LightRule::kGaussLegendre},
                                                           {"polar", LightRule::kPolar}};

struct LightDirection {
  Vec3 towards;               // unit, z > 0
  double solid_angle_sr;      // weight of the quadrature; all of them add up to about 2π
  std::size_t first;          // of the basis that light is expressed in: which function `basis` begins with
  std::vector<double> basis;  // values there; the other functions are 0
};

// polar × azimuths of them, the highest first; azimuths are even and begin half a step from +x.
// The basis: spherical harmonics.
std::vector<LightDirection> lightDirections(LightRule rule, int polar, int azimuths, int order);

// Of the side × side cells of the hemisphere (transport/hemisphere_grid.h) samples × samples each, at the places of a Gauss rule in the
// square, by which the mean of a flat patch's cosine is exact but for the cells on the square's diagonals. The basis: cells
// (LightBasis).
std::vector<LightDirection> cellLights(int side, int samples);

}  // namespace bakelight::rtt
