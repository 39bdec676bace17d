#include "tools/report/flip.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <Eigen/Dense>
#include <numbers>
#include <stdexcept>

#include "transport/color.h"

namespace bakelight::report {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;
using Plane = std::vector<float>;
constexpr double kPi = std::numbers::pi;

// Colour differences are raised to kColorExponent; kKnee of the largest one then takes kKneeError of the
// range of errors (section 4.1.3). Feature differences are raised to kFeatureExponent (section 4.2).
constexpr double kColorExponent = 0.7, kKnee = 0.4, kKneeError = 0.95, kFeatureExponent = 0.5;
constexpr double kFeatureWidth_deg = 0.082;  // peak to trough of the eye's edge detector

// ---- Colour spaces ----

Matrix3d xyzFromLinearRgb() {
  Matrix3d matrix;
  matrix << 10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794,  //
      2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897,          //
      1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382;
  return matrix;
}

// XYZ over that of white, so that white is (1, 1, 1).
Matrix3d relativeXyzFromLinearRgb() {
  const Matrix3d xyz = xyzFromLinearRgb();
  return (xyz * Vector3d::Ones()).cwiseInverse().asDiagonal() * xyz;
}

// Y, Cx, Cz: the linear opponent space that contrast sensitivity is known in.
Vector3d opponentFromRelativeXyz(const Vector3d& xyz) {
  return {116 * xyz[1] - 16, 500 * (xyz[0] - xyz[1]), 200 * (xyz[1] - xyz[2])};
}

Vector3d relativeXyzFromOpponent(const Vector3d& opponent) {
  const double y = (opponent[0] + 16) / 116;
  return {y + opponent[1] / 500, y, y - opponent[2] / 200};
}

// CIE L*a*b*, with chroma weighed by lightness: colours look paler in the dark (Hunt 1952).
Vector3d huntLabFromRelativeXyz(const Vector3d& xyz) {
  constexpr double kDelta = 6.0 / 29;
  const auto compressed = [](double value) {
    return value > kDelta * kDelta * kDelta ? std::cbrt(value) : value / (3 * kDelta * kDelta) + 4.0 / 29;
  };
  const Vector3d f(compressed(xyz[0]), compressed(xyz[1]), compressed(xyz[2]));
  const double lightness = 116 * f[1] - 16;
  return {lightness, 0.01 * lightness * 500 * (f[0] - f[1]), 0.01 * lightness * 200 * (f[1] - f[2])};
}

// Abasi, Tehran & Fairchild 2020: fit for large differences.
double hyabDistance(const Vector3d& a, const Vector3d& b) {
  return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

// ---- Separable filters; the border pixels go on outside ----

struct Size {
  int width, height;
};

// taps[r + i] weighs the pixel i to the right, r the radius.
Plane filteredRows(const Plane& plane, Size size, const std::vector<float>& taps) {
  const int radius = static_cast<int>(taps.size() / 2);
  Plane result(plane.size());
  tbb::parallel_for(0, size.height, [&](int y) {
    const float* const row = &plane[static_cast<std::size_t>(y) * size.width];
    std::vector<float> padded(size.width + 2 * radius);
    for (int x = 0; x < size.width + 2 * radius; ++x)
      padded[x] = row[std::clamp(x - radius, 0, size.width - 1)];
    float* const to = &result[static_cast<std::size_t>(y) * size.width];
    for (int i = 0; i <= 2 * radius; ++i)
      for (int x = 0; x < size.width; ++x) to[x] += taps[i] * padded[x + i];
  });
  return result;
}

Plane filteredColumns(const Plane& plane, Size size, const std::vector<float>& taps) {
  const int radius = static_cast<int>(taps.size() / 2);
  Plane result(plane.size());
  tbb::parallel_for(0, size.height, [&](int y) {
    float* const to = &result[static_cast<std::size_t>(y) * size.width];
    for (int i = -radius; i <= radius; ++i) {
      const float* const row =
          &plane[static_cast<std::size_t>(std::clamp(y + i, 0, size.height - 1)) * size.width];
      for (int x = 0; x < size.width; ++x) to[x] += taps[radius + i] * row[x];
    }
  });
  return result;
}

template <class Value>
std::vector<double> tapsOf(int radius, const Value& value) {
  std::vector<double> taps;
  for (int x = -radius; x <= radius; ++x) taps.push_back(value(static_cast<double>(x)));
  return taps;
}

// Positive taps add up to 1, and so do negative ones, as magnitudes.
std::vector<float> normalized(const std::vector<double>& taps) {
  double positive = 0, negative = 0;
  for (const double tap : taps) (tap > 0 ? positive : negative) += std::abs(tap);
  std::vector<float> result;
  for (const double tap : taps)
    result.push_back(static_cast<float>(tap > 0 ? tap / positive : tap < 0 ? tap / negative : 0));
  return result;
}

// ---- What the eye resolves ----

// A contrast sensitivity function as a sum of Gaussians a √(π/b) exp(−π² x²/b), x in degrees (section 4.1.1).
struct Gaussian {
  double a, b;
};
const std::vector<std::vector<Gaussian>>& sensitivities() {
  static const std::vector<std::vector<Gaussian>> kSensitivities = {
      {{1, 0.0047}}, {{1, 0.0053}}, {{34.1, 0.04}, {13.5, 0.025}}};  // achromatic, red–green, blue–yellow
  return kSensitivities;
}

Plane spatiallyFiltered(const Plane& plane, Size size, const std::vector<Gaussian>& sensitivity,
                        double pixels_per_degree) {
  constexpr double kWidest = 0.04;
  const int radius =
      static_cast<int>(std::ceil(3 * std::sqrt(kWidest / (2 * kPi * kPi)) * pixels_per_degree));
  Plane sum(plane.size());
  double total = 0;
  for (const Gaussian& gaussian : sensitivity) {
    const std::vector<double> taps = tapsOf(radius, [&](double x) {
      return std::exp(-kPi * kPi * x * x / (gaussian.b * pixels_per_degree * pixels_per_degree));
    });
    double taps_sum = 0;
    for (const double tap : taps) taps_sum += tap;
    const double weight = gaussian.a * std::sqrt(kPi / gaussian.b) * taps_sum * taps_sum;
    const std::vector<float> unit_taps = normalized(taps);
    const Plane filtered = filteredColumns(filteredRows(plane, size, unit_taps), size, unit_taps);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += static_cast<float>(weight) * filtered[i];
    total += weight;
  }
  for (float& value : sum) value /= static_cast<float>(total);
  return sum;
}

// Length of the vector of a detector's answers along x and along y.
Plane detected(const Plane& lightness, Size size, const std::vector<float>& detector,
               const std::vector<float>& smoothing) {
  const Plane along_x = filteredColumns(filteredRows(lightness, size, detector), size, smoothing);
  const Plane along_y = filteredColumns(filteredRows(lightness, size, smoothing), size, detector);
  Plane length(lightness.size());
  for (std::size_t i = 0; i < length.size(); ++i) length[i] = std::hypot(along_x[i], along_y[i]);
  return length;
}

FlipReference::Perceived perceive(const formats::Image& display, double pixels_per_degree) {
  const Size size{display.width, display.height};
  const std::size_t pixels = static_cast<std::size_t>(size.width) * size.height;
  const Matrix3d xyz_from_rgb = relativeXyzFromLinearRgb(), rgb_from_xyz = xyz_from_rgb.inverse();
  std::array<Plane, 3> opponent = {Plane(pixels), Plane(pixels), Plane(pixels)};
  for (std::size_t i = 0; i < pixels; ++i) {
    const float* encoded = &display.values[i * display.channelCount()];
    const Vector3d rgb(transport::linearFromSrgb(encoded[0]), transport::linearFromSrgb(encoded[1]),
                       transport::linearFromSrgb(encoded[2]));
    const Vector3d color = opponentFromRelativeXyz(xyz_from_rgb * rgb);
    for (int c = 0; c < 3; ++c) opponent[c][i] = static_cast<float>(color[c]);
  }

  FlipReference::Perceived perceived;
  Plane lightness = opponent[0];
  for (float& value : lightness) value = (value + 16) / 116;
  const double deviation_px = kFeatureWidth_deg / 2 * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * deviation_px));
  const auto gaussian = [&](double x) { return std::exp(-x * x / (2 * deviation_px * deviation_px)); };
  const std::vector<float> smoothing = normalized(tapsOf(radius, gaussian));
  perceived.edges = detected(
      lightness, size, normalized(tapsOf(radius, [&](double x) { return -x * gaussian(x); })), smoothing);
  perceived.points = detected(
      lightness, size,
      normalized(tapsOf(radius,
                        [&](double x) { return (x * x / (deviation_px * deviation_px) - 1) * gaussian(x); })),
      smoothing);

  for (std::size_t c = 0; c < 3; ++c)
    opponent[c] = spatiallyFiltered(opponent[c], size, sensitivities()[c], pixels_per_degree);
  perceived.color.resize(3 * pixels);
  tbb::parallel_for(std::size_t{0}, pixels, [&](std::size_t i) {
    const Vector3d rgb =
        rgb_from_xyz * relativeXyzFromOpponent({opponent[0][i], opponent[1][i], opponent[2][i]});
    const Vector3d lab = huntLabFromRelativeXyz(xyz_from_rgb * rgb.cwiseMax(0.0).cwiseMin(1.0));
    for (int c = 0; c < 3; ++c) perceived.color[3 * i + c] = static_cast<float>(lab[c]);
  });
  return perceived;
}

// ---- Differences ----

// Of the two most different colours on a display, green and blue.
double largestColorDifference() {
  const Matrix3d xyz = relativeXyzFromLinearRgb();
  return std::pow(hyabDistance(huntLabFromRelativeXyz(xyz.col(1)), huntLabFromRelativeXyz(xyz.col(2))),
                  kColorExponent);
}

double colorError(const float* a, const float* b) {
  static const double largest = largestColorDifference();
  const double difference = std::pow(hyabDistance({a[0], a[1], a[2]}, {b[0], b[1], b[2]}), kColorExponent);
  const double knee = kKnee * largest;
  if (difference < knee) return kKneeError / knee * difference;
  return kKneeError + (difference - knee) / (largest - knee) * (1 - kKneeError);
}

}  // namespace

double defaultPixelsPerDegree() {
  return 3840 * kPi / 180;
}

FlipReference::FlipReference(const formats::Image& reference, double pixels_per_degree)
    : width_(reference.width), height_(reference.height), pixels_per_degree_(pixels_per_degree) {
  if (reference.channelCount() < 3) throw std::invalid_argument("FLIP compares colour pictures");
  reference_ = perceive(reference, pixels_per_degree);
}

std::vector<float> FlipReference::errorsOf(const formats::Image& test) const {
  if (test.width != width_ || test.height != height_ || test.channelCount() < 3)
    throw std::invalid_argument("FLIP compares colour pictures of one size");
  const Perceived perceived = perceive(test, pixels_per_degree_);
  std::vector<float> errors(perceived.edges.size());
  tbb::parallel_for(std::size_t{0}, errors.size(), [&](std::size_t i) {
    const double color = colorError(&reference_.color[3 * i], &perceived.color[3 * i]);
    const double feature = std::max(std::abs(reference_.edges[i] - perceived.edges[i]),
                                    std::abs(reference_.points[i] - perceived.points[i]));
    errors[i] =
        static_cast<float>(std::pow(color, 1 - std::pow(feature / std::numbers::sqrt2, kFeatureExponent)));
  });
  return errors;
}

}  // namespace bakelight::report
