#include "transport/sky.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "transport/gauss_legendre.h"

namespace bakelight::transport {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRadiansPerDegree = kPi / 180;
using Rgb = Sky::Rgb;

// Linear in the turbidity: slope and value at 0, for A … E (appendix A.2 of the paper).
using Perez = std::array<std::array<double, 2>, 5>;
constexpr std::array<Perez, 3> kShapes = {{
    {{{0.1787, -1.4630}, {-0.3554, 0.4275}, {-0.0227, 5.3251}, {0.1206, -2.5771}, {-0.0670, 0.3703}}},    // Y
    {{{-0.0193, -0.2592}, {-0.0665, 0.0008}, {-0.0004, 0.2125}, {-0.0641, -0.8989}, {-0.0033, 0.0452}}},  // x
    {{{-0.0167, -0.2608}, {-0.0950, 0.0092}, {-0.0079, 0.2102}, {-0.0441, -1.6537}, {-0.0109, 0.0529}}},  // y
}};

// Zenith chromaticity: rows for turbidity², turbidity, 1; columns for θ³, θ², θ, 1 of the sun.
using Chromaticity = std::array<std::array<double, 4>, 3>;
constexpr Chromaticity kZenithX = {{{0.00166, -0.00375, 0.00209, 0},
                                    {-0.02903, 0.06377, -0.03202, 0.00394},
                                    {0.11693, -0.21196, 0.06052, 0.25886}}};
constexpr Chromaticity kZenithY = {{{0.00275, -0.00610, 0.00317, 0},
                                    {-0.04214, 0.08970, -0.04153, 0.00516},
                                    {0.15346, -0.26756, 0.06670, 0.26688}}};

// 380, 390 … 750 nm: the sun's spectral radiance above the air in 100 W / (m² nm sr), and the absorption of
// ozone in 1/cm.
constexpr double kFirstWavelength_nm = 380, kWavelengthStep_nm = 10;
constexpr std::array<double, 38> kSunSpectrum = {
    165.5, 162.3, 211.2, 258.8, 258.2, 242.3, 267.6, 296.6, 305.4, 300.6, 306.6, 288.3, 287.1,
    278.2, 271.0, 272.3, 263.6, 255.0, 250.6, 253.1, 253.5, 251.3, 246.3, 241.7, 236.8, 232.1,
    228.2, 223.4, 219.7, 215.3, 211.0, 207.3, 202.4, 198.7, 194.3, 190.7, 186.3, 182.6};
constexpr std::array<double, 38> kOzone = {
    0,     0,     0,     0,     0,     0,     0,     0.003, 0.006, 0.009, 0.014, 0.021, 0.030,
    0.040, 0.048, 0.063, 0.075, 0.085, 0.103, 0.120, 0.120, 0.115, 0.125, 0.120, 0.105, 0.090,
    0.079, 0.067, 0.057, 0.048, 0.036, 0.028, 0.023, 0.018, 0.014, 0.011, 0.010, 0.009};
constexpr double kOzone_cm = 0.35, kAngstromExponent = 1.3;
constexpr double kLumensPerWatt = 683;

double zenithLuminance(double turbidity, double sun_zenith_rad) {
  const double chi = (4.0 / 9 - turbidity / 120) * (kPi - 2 * sun_zenith_rad);
  return (4.0453 * turbidity - 4.9710) * std::tan(chi) - 0.2155 * turbidity + 2.4192;  // kcd/m²
}

double zenithChromaticity(const Chromaticity& table, double turbidity, double sun_zenith_rad) {
  const double t = sun_zenith_rad;
  double value = 0;
  for (const auto& row : table) value = value * turbidity + ((row[0] * t + row[1]) * t + row[2]) * t + row[3];
  return value;
}

Rgb rgbFromXyz(double x, double y, double z) {
  const Rgb linear(3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
                   -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
                   0.0556434 * x - 0.2040259 * y + 1.0572252 * z);
  return linear.max(0.0);
}

// The CIE 1931 colour-matching functions, as fitted by Wyman, Sloan & Shirley 2013.
Rgb colorMatching(double wavelength_nm) {
  const auto lobe = [&](double center, double below, double above) {
    const double t = (wavelength_nm - center) / (wavelength_nm < center ? below : above);
    return std::exp(-0.5 * t * t);
  };
  return {1.056 * lobe(599.8, 37.9, 31.0) + 0.362 * lobe(442.0, 16.0, 26.7) - 0.065 * lobe(501.1, 20.4, 26.2),
          0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1),
          1.217 * lobe(437.0, 11.8, 36.0) + 0.681 * lobe(459.0, 26.0, 13.8)};
}

// Of the air along the sun's rays at one wavelength: molecules, aerosols, ozone.
double transmittance(double wavelength_um, double ozone_per_cm, double air_mass, double turbidity) {
  const double haze = 0.04608 * turbidity - 0.04586;  // Ångström's β
  const double depth = 0.008735 * std::pow(wavelength_um, -4.08) +
                       haze * std::pow(wavelength_um, -kAngstromExponent) + ozone_per_cm * kOzone_cm;
  return std::exp(-depth * air_mass);
}

// kcd/m², linear sRGB.
Rgb sunDiskRadiance(double turbidity, double sun_zenith_rad) {
  const double zenith_deg = sun_zenith_rad / kRadiansPerDegree;
  const double air_mass = 1 / (std::cos(sun_zenith_rad) + 0.15 * std::pow(93.885 - zenith_deg, -1.253));
  Rgb xyz = Rgb::Zero();
  for (std::size_t i = 0; i < kSunSpectrum.size(); ++i) {
    const double wavelength_nm = kFirstWavelength_nm + kWavelengthStep_nm * static_cast<double>(i);
    const double radiance =
        100 * kSunSpectrum[i] * transmittance(wavelength_nm / 1000, kOzone[i], air_mass, turbidity);
    xyz += radiance * colorMatching(wavelength_nm) * kWavelengthStep_nm;
  }
  xyz *= kLumensPerWatt / 1000;
  return rgbFromXyz(xyz[0], xyz[1], xyz[2]);
}

Vec3 directionAt(double elevation_deg, double azimuth_deg) {
  const double elevation = elevation_deg * kRadiansPerDegree, azimuth = azimuth_deg * kRadiansPerDegree;
  return {std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
          std::cos(elevation) * std::cos(azimuth)};
}

// Perez's luminance distribution F(θ, γ) (eq. 4 of the paper): θ from the zenith, γ from the sun.
double perez(const std::array<double, 5>& shape, double zenith_cosine, double gamma_rad) {
  const double gamma_cosine = std::cos(gamma_rad);
  const double horizon = 1 + shape[0] * std::exp(shape[1] / std::max(zenith_cosine, 1e-4));
  return horizon * (1 + shape[2] * std::exp(shape[3] * gamma_rad) + shape[4] * gamma_cosine * gamma_cosine);
}

// Calls visit(direction, weight_sr) for a product rule over the upper half: Gauss–Legendre in height, equal
// steps in azimuth.
template <class Visit>
void forUpperHalf(const Visit& visit) {
  constexpr int kRows = 96, kColumns = 384;
  static const std::vector<QuadratureNode> rule = gaussLegendreRule(kRows);
  for (const auto& [x, weight] : rule) {
    const double height = (1 + x) / 2, radius = std::sqrt(1 - height * height);
    for (int column = 0; column < kColumns; ++column) {
      const double azimuth = 2 * kPi * (column + 0.5) / kColumns;
      visit(Vec3(radius * std::sin(azimuth), height, radius * std::cos(azimuth)), kPi / kColumns * weight);
    }
  }
}

Float3 float3(const Rgb& rgb) {
  return {static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2])};
}

}  // namespace

Sky::Sky(const formats::SkyLight& light)
    : is_day_(light.sun_elevation_deg >= 0),
      intensity_(light.intensity),
      sun_direction_(directionAt(light.sun_elevation_deg, light.sun_azimuth_deg)),
      sun_zenith_rad_((90 - light.sun_elevation_deg) * kRadiansPerDegree) {
  if (!is_day_) return;
  const double turbidity = light.turbidity;
  for (std::size_t i = 0; i < distributions_.size(); ++i)
    for (std::size_t k = 0; k < 5; ++k)
      distributions_[i].shape[k] = kShapes[i][k][0] * turbidity + kShapes[i][k][1];
  distributions_[0].zenith = zenithLuminance(turbidity, sun_zenith_rad_);
  distributions_[1].zenith = zenithChromaticity(kZenithX, turbidity, sun_zenith_rad_);
  distributions_[2].zenith = zenithChromaticity(kZenithY, turbidity, sun_zenith_rad_);

  if (light.sun) sun_radiance_ = intensity_ * sunDiskRadiance(turbidity, sun_zenith_rad_);
  const double sun_size = kPi * std::pow(std::sin(kSunHalfAngle_rad), 2);  // projected, facing it
  const Rgb irradiance = skyIrradiance() + sun_radiance_ * sun_size * std::max(sun_direction_.y(), 0.0);
  for (int c = 0; c < 3; ++c)
    ground_radiance_[c] = light.ground_albedo[static_cast<std::size_t>(c)] / kPi * irradiance[c];
}

double Sky::evaluate(const Distribution& distribution, double zenith_cosine, double sun_cosine) const {
  return distribution.zenith * perez(distribution.shape, zenith_cosine, std::acos(sun_cosine)) /
         perez(distribution.shape, 1, sun_zenith_rad_);
}

Sky::Rgb Sky::skyRadiance(double zenith_cosine, double sun_cosine) const {
  const double luminance = evaluate(distributions_[0], zenith_cosine, sun_cosine);
  const double x = evaluate(distributions_[1], zenith_cosine, sun_cosine);
  const double y = evaluate(distributions_[2], zenith_cosine, sun_cosine);
  return intensity_ * rgbFromXyz(x / y * luminance, luminance, (1 - x - y) / y * luminance);
}

Sky::Rgb Sky::radiance(const Vec3& direction) const {
  if (!is_day_) return Rgb::Zero();
  if (direction.y() < 0) return ground_radiance_;
  return skyRadiance(direction.y(), std::clamp(direction.dot(sun_direction_), -1.0, 1.0));
}

Sky::Rgb Sky::skyIrradiance() const {
  Rgb irradiance = Rgb::Zero();
  forUpperHalf([&](const Vec3& direction, double weight_sr) {
    irradiance += radiance(direction) * direction.y() * weight_sr;
  });
  return irradiance;
}

ShLight skyLight(const Sky& sky, int order) {
  const int count = coefficientCount(order);
  std::vector<Rgb> total(count, Rgb::Zero());
  std::vector<double> basis(count);
  forUpperHalf([&](const Vec3& direction, double weight_sr) {
    const Rgb radiance = sky.radiance(direction) * weight_sr;
    evaluateSh(order, direction, basis);
    for (int i = 0; i < count; ++i) total[i] += radiance * basis[i];
  });
  ShLight light(count);
  for (int i = 0; i < count; ++i) light[i] = float3(total[i]);
  light = sum(light, diskLight(order, -Vec3::UnitY(), kPi / 2, float3(sky.groundRadiance())));
  return sum(light, diskLight(order, sky.sunDirection(), kSunHalfAngle_rad, float3(sky.sunRadiance())));
}

}  // namespace bakelight::transport
