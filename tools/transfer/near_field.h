// Transfer of light that shines from a virtual sphere around the object instead of from infinity (Fujita &
// Kanai 2004, section 3.1).
#pragma once

#include <span>
#include <vector>

#include "tools/transfer/quadrature.h"
#include "transport/vector_types.h"

namespace bakelight::transfer {

struct VirtualSphere {
  transport::Vec3 center = transport::Vec3::Zero();
  double radius = 0;
};

// A source on the sphere's wall at x', seen from the centre with radiance L over the solid angle dω, has the
// intensity L r² dω, so at a point x it gives the irradiance L dω cos θ r²/|x − x'|². Integrated over the
// directions s that leave x (dω = dω_s |x − x'|² / (r² cos θ'), θ' the angle between s and the wall's
// normal):
//   T_i = 1/π ∫ V(s) cos θ / cos θ' y_i(c(s)) ds,  c(s) the direction from the centre to where s meets the
//   wall.
// This computes the difference to distant light, 1/π ∫ V cos θ (y_i(c)/cos θ' − y_i(s)) ds, from the
// directions that are not blocked; it vanishes as the sphere grows. `difference` has order² entries. Cost:
// order² evaluations a direction.
void nearFieldDifference(const VirtualSphere& sphere, const transport::Vec3& point, int order,
                         const Quadrature& quadrature, std::span<const std::uint32_t> visible_directions,
                         std::span<const float> cosines, std::span<double> difference);

}  // namespace bakelight::transfer
