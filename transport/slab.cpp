#include "transport/slab.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace bakelight::transport {
namespace {

// ln(sinh(x a) / sinh(x b)) for 0 < a ≤ b, which is ln(a / b) for x = 0.
double logSinhRatio(double x, double a, double b) {
  if (x * b < 1e-6) return std::log(a / b);
  return x * (a - b) + std::log(std::expm1(-2 * x * a) / std::expm1(-2 * x * b));
}
double logCosh(double x) {
  return x + std::log1p(std::exp(-2 * x)) - std::log(2.0);
}

double logTransmittance(const ScatteringCoefficients& c, double thickness) {
  const double diffuse = 2 * fresnelMoments(1 / c.relative_ior).first;
  const double beyond = 2 * (1 + diffuse) / (1 - diffuse) / (3 * c.extinction());
  const double attenuation = std::sqrt(3 * c.absorption * c.extinction());
  const double depth = c.extinction() * thickness, scattered = -std::expm1(-depth);
  const double source =
      depth < 1e-6 ? thickness / 2 : (scattered - depth * std::exp(-depth)) / (scattered * c.extinction());
  const double through = std::log(c.albedo() * scattered) + logCosh(attenuation * beyond) +
                         logSinhRatio(attenuation, source + beyond, thickness + 2 * beyond);
  const double greater = std::max(through, -depth), lesser = std::min(through, -depth);
  return std::min(greater + std::log1p(std::exp(lesser - greater)), 0.0);
}

}  // namespace

SlabTransmission slabTransmission(const ScatteringCoefficients& coefficients, double thickness) {
  if (!(thickness > 0)) throw std::invalid_argument("a layer has a thickness above 0");
  [[maybe_unused]] const DiffuseReflectance checked(DiffusionModel::kDipole,
                                                    coefficients);  // throws for what is no medium
  const double with = logTransmittance(coefficients, thickness);
  const double without =
      logTransmittance({coefficients.reduced_scattering, 0, coefficients.relative_ior}, thickness);
  return {std::exp(without), std::max(without - with, 0.0) / thickness};
}

}  // namespace bakelight::transport
