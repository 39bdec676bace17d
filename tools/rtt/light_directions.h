// The directional lights that a patch is seen under.
#pragma once

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
  std::vector<double> basis;  // y_i there
};

// polar × azimuths of them, the highest first; azimuths are even and begin half a step from +x.
std::vector<LightDirection> lightDirections(LightRule rule, int polar, int azimuths, int order);

}  // namespace bakelight::rtt
