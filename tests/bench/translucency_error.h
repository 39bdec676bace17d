// How far a translucent object as it is played is from the integral that it stands for, without any noise: the same R_d summed over all texels of
// the surface, at some of the receivers.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "formats/translucency.h"
#include "tools/kernels/reflectance.h"
#include "tools/kernels/texels.h"

namespace bakelight::bench {

// Relative RMSE, √Σ (B − truth)² ÷ √Σ truth² over receivers and colors, of what is played and of its parts and rivals.
struct TranslucencyErrors {
  double blend = 0, local = 0, global = 0;
  double naive =
      0;  // kernels of R_d and factors with a diagonal of 0 added up, Lensch et al. 2002 before their section 5.4
  double total = 0;  // Σ B ÷ Σ truth − 1
};
// Light at a point of the surface.
using LightOnSurface = std::function<float(const Eigen::Vector3f& position, const Eigen::Vector3f& normal)>;
TranslucencyErrors translucencyErrors(const kernels::Knots& knots, const kernels::Texels& texels,
                                      const kernels::Reflectance& reflectance,
                                      const formats::Translucency& translucency, const LightOnSurface& light,
                                      std::size_t receivers);

// "smooth", "spot", "checkerboard", over an object of that size about its middle.
std::vector<std::pair<std::string, LightOnSurface>> testLights(const kernels::Knots& knots);

}  // namespace bakelight::bench
