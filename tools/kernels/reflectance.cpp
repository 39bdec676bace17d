#include "tools/kernels/reflectance.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace bakelight::kernels {
namespace {

using transport::DiffuseReflectance;

constexpr float kBandReach = 6;  // sides of a texel
constexpr int kBandNodes = 192;
constexpr double kBandRatio = 1.04;  // between sides of neighbouring tables
constexpr int kMostBands = 96;

template <class Function>
Rgb eachColor(const std::array<DiffuseReflectance, 3>& colors, const Function& function) {
  return {static_cast<float>(function(colors[0])), static_cast<float>(function(colors[1])),
          static_cast<float>(function(colors[2]))};
}

// Value, slope and curvature at a distance.
std::array<double, 3> derivativesOf(const DiffuseReflectance& color, double distance) {
  const double h = 1e-3 * distance;
  const double before = color(distance - h), at = color(distance), after = color(distance + h);
  return {at, (after - before) / (2 * h), (after - 2 * at + before) / (h * h)};
}

// Coefficients of the polynomial in the squared distance.
std::array<double, 3> smoothCoefficients(const DiffuseReflectance& color, double radius) {
  const auto [value, slope, curvature] = derivativesOf(color, radius);
  const double quadratic = (curvature - slope / radius) / (8 * radius * radius);
  const double linear = (slope / radius - 4 * quadratic * radius * radius) / 2;
  return {value - radius * radius * (linear + quadratic * radius * radius), linear, quadratic};
}

}  // namespace

transport::ScatteringCoefficients coefficientsOf(const formats::Medium& medium, std::size_t color) {
  return {medium.reduced_scattering[color] * medium.unit_mm, medium.absorption[color] * medium.unit_mm,
          medium.eta};
}

std::array<DiffuseReflectance, 3> reflectanceOf(const formats::Medium& medium) {
  const auto color = [&](std::size_t c) {
    return DiffuseReflectance(medium.model, coefficientsOf(medium, c));
  };
  return {color(0), color(1), color(2)};
}

Reflectance::Reflectance(const transport::MediumField& field, double farthest, double least_texel,
                         double greatest_texel)
    : field_(field), farthest_(farthest), least_texel_(least_texel) {
  const auto media = field.reflectances();
  const double scale = least_texel / 4, least = scale / 64;
  const bool by_color = field.isOfSurface();
  exact_ = RadialTable<Rgb>(scale, farthest, media.size(), by_color, [&](double r, std::size_t medium) {
    return eachColor(media[medium],
                     [&](const DiffuseReflectance& color) { return color(std::max(r, least)); });
  });
  inner_ =
      RadialTable<Polynomial>(scale, farthest, media.size(), by_color, [&](double r, std::size_t medium) {
        Polynomial polynomial;
        for (Eigen::Index c = 0; c < 3; ++c) {
          const auto powers =
              smoothCoefficients(media[medium][static_cast<std::size_t>(c)], std::max(r, scale));
          for (Eigen::Index k = 0; k < 3; ++k)
            polynomial(c, k) = static_cast<float>(powers[static_cast<std::size_t>(k)]);
        }
        return polynomial;
      });

  const double range = std::log(greatest_texel / least_texel);
  const int count = std::clamp(static_cast<int>(std::ceil(range / std::log(kBandRatio))) + 1, 2, kMostBands);
  log_step_ = range > 0 ? range / (count - 1) : 1;
  bands_.resize(static_cast<std::size_t>(count));
  std::vector<double> distances;
  for (int i = 0; i < kBandNodes; ++i)
    distances.push_back(static_cast<double>(kBandReach) * i / (kBandNodes - 1));
  const transport::BandLimit limit(distances);
  tbb::parallel_for(std::size_t{0}, bands_.size(), [&](std::size_t b) {
    const double side = least_texel * std::exp(log_step_ * static_cast<double>(b));
    bands_[b].resize(kBandNodes * media.size());
    for (std::size_t m = 0; m < media.size(); ++m)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::vector<double> values = limit(media[m][c], side);
        for (std::size_t i = 0; i < kBandNodes; ++i)
          bands_[b][i * media.size() + m][static_cast<Eigen::Index>(c)] = static_cast<float>(values[i]);
      }
  });
}

float Reflectance::greatest(float distance) const {
  float most = 0;
  for (std::uint32_t m = 0; m < field_.reflectances().size(); ++m)
    most = std::max(most, exact(distance, Place::at(m)).maxCoeff());
  return most;
}

std::uint32_t Reflectance::bandOf(float side) const {
  const double place = std::log(static_cast<double>(side) / least_texel_) / log_step_;
  return static_cast<std::uint32_t>(std::clamp(std::lround(place), 0L, static_cast<long>(bands_.size()) - 1));
}

Rgb Reflectance::betweenTexels(float distance, float side, std::uint32_t band, const Place& place) const {
  const float sides = distance / side;
  if (sides >= kBandReach) return exact_(distance, place);
  const float node = sides / kBandReach * (kBandNodes - 1);
  const auto first = static_cast<std::size_t>(std::min(static_cast<int>(node), kBandNodes - 2));
  const std::size_t media = field_.reflectances().size();
  const Rgb* from = &bands_[band][first * media];
  return RadialTable<Rgb>::between(from, from + media, node - static_cast<float>(first), place,
                                   field_.isOfSurface()) /
         (side * side);
}

double Reflectance::reach(double share) const {
  double farthest = 0;
  for (const auto& colors : field_.reflectances())
    for (const DiffuseReflectance& color : colors) farthest = std::max(farthest, color.radiusFor(share));
  return farthest;
}

double Reflectance::shareBeyond(double radius) const {
  double most = 0;
  for (const auto& colors : field_.reflectances())
    for (const DiffuseReflectance& color : colors)
      most = std::max(most, color.total() - color.enclosed(radius));
  return most;
}

}  // namespace bakelight::kernels
