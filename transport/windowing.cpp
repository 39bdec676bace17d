#include "transport/windowing.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "transport/directions.h"

namespace bakelight::transport {
namespace {

// Ten bands vary by half a period in 18°; neighbours of this lattice are 2° apart.
constexpr int kLatticeSize = 8192;
// Between photographed scenes and a sun almost alone. At order 5 eight probes, outdoors and indoors, ring to
// between -0.2 and -2.6 times their mean, a single direction to -3.8.
constexpr double kLoudRinging = -2.7;
constexpr int kBisections = 50;  // of the logarithm of λ

int orderOf(const ShLight& light) {
  const int order = static_cast<int>(std::lround(std::sqrt(static_cast<double>(light.size()))));
  if (order < 1 || coefficientCount(order) != static_cast<int>(light.size()))
    throw std::invalid_argument("a light has order² coefficients");
  return order;
}

double squaredNormBeyondMean(const ShLight& light) {
  double sum = 0;
  for (std::size_t i = 1; i < light.size(); ++i)
    for (const float value : light[i]) sum += static_cast<double>(value) * value;
  return sum;
}

// The light's luminance at the lattice's directions, each band by itself, so that a window is a weighted sum.
class BandLuminance {
 public:
  explicit BandLuminance(const ShLight& light) : order_(orderOf(light)) {
    std::vector<double> coefficients(light.size()), basis(light.size());
    for (std::size_t i = 0; i < light.size(); ++i) coefficients[i] = luminance(light[i]);
    mean_ = coefficients[0] * std::sqrt(1 / (4 * std::numbers::pi));
    bands_.reserve(static_cast<std::size_t>(kLatticeSize) * order_);
    for (const Vec3& direction : sphereDirections(kLatticeSize)) {
      evaluateSh(order_, direction, basis);
      for (int l = 0; l < order_; ++l) {
        double band = 0;
        for (int i = l * l; i < (l + 1) * (l + 1); ++i) band += coefficients[i] * basis[i];
        bands_.push_back(band);
      }
    }
  }

  double mean() const { return mean_; }

  double minimum(double lambda) const {
    std::vector<double> factors(order_);
    for (int l = 0; l < order_; ++l) factors[l] = bandFactor(l, lambda);
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t first = 0; first < bands_.size(); first += order_) {
      double value = 0;
      for (int l = 0; l < order_; ++l) value += factors[l] * bands_[first + l];
      least = std::min(least, value);
    }
    return least;
  }

 private:
  int order_;
  double mean_ = 0;
  std::vector<double> bands_;  // direction by direction
};

}  // namespace

double bandFactor(int l, double lambda) {
  const double laplacian = static_cast<double>(l) * (l + 1);
  return 1 / (1 + lambda * laplacian * laplacian);
}

WindowedLight window(const ShLight& light, double lambda) {
  const int order = orderOf(light);
  if (!(lambda >= 0)) throw std::invalid_argument("the strength of a window is 0 or more");
  WindowedLight windowed{light, lambda, 0};
  for (int l = 1; l < order; ++l) {
    const double factor = bandFactor(l, lambda);
    for (int i = l * l; i < (l + 1) * (l + 1); ++i)
      for (float& value : windowed.light[i]) value = static_cast<float>(value * factor);
  }
  const double before = squaredNormBeyondMean(light);
  if (before > 0 && lambda > 0) windowed.moved_energy = 1 - squaredNormBeyondMean(windowed.light) / before;
  return windowed;
}

WindowedLight windowUntilPositive(const ShLight& light, double tolerance) {
  const BandLuminance luminance(light);
  const double floor = -tolerance * luminance.mean();
  const auto suffices = [&](double lambda) { return luminance.minimum(lambda) >= floor; };
  // Nothing to hold on to where the mean itself is dark.
  if (!(luminance.mean() > 0) || suffices(0)) return window(light, 0);

  double weak = 1e-9, strong = weak;
  while (!suffices(strong) && strong < 1e9) weak = strong, strong *= 4;
  for (int i = 0; i < kBisections && strong > weak * (1 + 1e-9); ++i) {
    const double middle = std::sqrt(weak * strong);
    (suffices(middle) ? strong : weak) = middle;
  }
  return window(light, strong);
}

double minimumOverMean(const ShLight& light) {
  const BandLuminance luminance(light);
  return luminance.mean() > 0 ? luminance.minimum(0) / luminance.mean() : 0;
}

std::string ringingWarning(double minimum_over_mean, double lambda) {
  if (minimum_over_mean >= kLoudRinging) return "";
  return "the light rings: its luminance falls to " + fmt::format("{:.2g}", minimum_over_mean) +
         " times its mean, far below zero, so surfaces that face there turn too dark or black; " +
         (lambda > 0 ? "a stronger \"windowing\"" : "\"windowing\": 0.01, or \"auto\"") +
         " softens it, and so does a larger sun or lamp, or a higher order";
}

}  // namespace bakelight::transport
