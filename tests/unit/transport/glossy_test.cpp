#include "transport/glossy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>

#include "tests/unit/transport/quadrature.h"

namespace bakelight::transport {
namespace {

constexpr double kPi = std::numbers::pi;

// g_l = ∫ w(t) P_l(t) dt / ∫ w(t) dt over t = cos θ in 0 … 1, by brute force: midpoints in a variable that
// crowds the samples at the peak, θ = (π/2) s³.
std::vector<double> bruteKernel(int order, const std::function<double(double)>& weight_of_angle) {
  constexpr int kSamples = 400000;
  std::vector<double> kernel(order, 0.0);
  double norm = 0;
  for (int sample = 0; sample < kSamples; ++sample) {
    const double s = (sample + 0.5) / kSamples, angle = kPi / 2 * s * s * s;
    const double weight = weight_of_angle(angle) * std::sin(angle) * s * s;
    const std::vector<double> p = legendre(order, std::cos(angle));
    for (int l = 0; l < order; ++l) kernel[l] += weight * p[l];
    norm += weight;
  }
  for (double& factor : kernel) factor /= norm;
  return kernel;
}

TEST(PhongKernel, EqualsQuadrature) {
  for (const double exponent : {0.0, 0.5, 1.0, 7.0, 10.0, 100.0, 1e4, 1e6}) {
    const std::vector<double> kernel = phongKernel(10, exponent);
    const std::vector<double> expected =
        bruteKernel(10, [&](double angle) { return std::pow(std::cos(angle), exponent); });
    for (int l = 0; l < 10; ++l)
      EXPECT_NEAR(kernel[l], expected[l], 1e-8) << "exponent " << exponent << ", band " << l;
  }
}

// Exponent 1 is the clamped cosine over π.
TEST(PhongKernel, OfExponentOneIsTheClampedCosine) {
  const std::vector<double> kernel = phongKernel(10, 1), cosine = clampedCosineFactors(10);
  for (int l = 0; l < 10; ++l) EXPECT_NEAR(kernel[l], cosine[l] / kPi, 1e-14);
}

TEST(PhongKernel, SharpensTowardsAMirror) {
  for (const double factor : phongKernel(10, 1e9)) EXPECT_NEAR(factor, 1, 1e-7);
  const std::vector<double> wide = phongKernel(10, 20), narrow = phongKernel(10, 40);
  for (int l = 1; l < 10; ++l) EXPECT_LT(wide[l], narrow[l]);
}

TEST(GgxKernel, EqualsQuadrature) {
  for (const double roughness : {0.1, 0.3, 0.5, 0.8, 1.0}) {
    const double alpha2 = std::pow(roughness, 4);
    const std::vector<double> expected = bruteKernel(10, [&](double angle) {
      const double cosine = std::cos(angle / 2);
      const double d = cosine * cosine * (alpha2 - 1) + 1;
      return std::cos(angle) * alpha2 / (kPi * d * d);
    });
    const std::vector<double> kernel = ggxKernel(10, roughness);
    for (int l = 0; l < 10; ++l)
      EXPECT_NEAR(kernel[l], expected[l], 1e-8) << "roughness " << roughness << ", band " << l;
  }
}

TEST(GgxKernel, IsAMirrorInTheLimit) {
  EXPECT_EQ(ggxKernel(10, 0), std::vector<double>(10, 1.0));
  for (const double roughness : {1e-100, 1e-8, 1e-5, 1e-3})
    for (const double factor : ggxKernel(10, roughness)) EXPECT_NEAR(factor, 1, 1e-8) << roughness;
  // Monotone in between.
  std::vector<double> last = ggxKernel(10, 0);
  for (double roughness = 0.01; roughness <= 1; roughness += 0.01) {
    const std::vector<double> kernel = ggxKernel(10, roughness);
    EXPECT_DOUBLE_EQ(kernel[0], 1);
    for (int l = 1; l < 4; ++l) EXPECT_LT(kernel[l], last[l]) << roughness;
    last = kernel;
  }
}

TEST(GgxKernel, OfRoughnessOneIsTheClampedCosine) {
  const std::vector<double> kernel = ggxKernel(10, 1), cosine = clampedCosineFactors(10);
  for (int l = 0; l < 10; ++l) EXPECT_NEAR(kernel[l], cosine[l] / kPi, 1e-14);
}

// Under light of the projected lobe's own order, the row gives ∫ lobe(s · r) L(s) ds.
TEST(LobeRow, ConvolvesAtTheReflectionDirection) {
  const int order = 5;
  const double exponent = 3;  // odd and low: the lobe over the hemisphere is what is integrated
  const Vec3 eye = Vec3(0.3, -0.5, 0.7).normalized(), reflection(-eye.x(), -eye.y(), eye.z());
  std::vector<double> light(coefficientCount(order));
  for (std::size_t i = 0; i < light.size(); ++i) light[i] = std::sin(1.0 + 2.0 * static_cast<double>(i));

  // Gauss–Legendre over the lobe's own hemisphere, in a frame around the reflection direction.
  const Vec3 side = reflection.unitOrthogonal(), up = reflection.cross(side);
  double expected = 0;
  for (const auto& [z, weight] : gaussLegendreRule(24))
    for (int j = 0; j < 48; ++j) {
      const double cosine = (z + 1) / 2, sine = std::sqrt(1 - cosine * cosine), phi = 2 * kPi * j / 48;
      const Vec3 s = sine * std::cos(phi) * side + sine * std::sin(phi) * up + cosine * reflection;
      const std::vector<double> y = evaluateSh(order, s);
      double radiance = 0;
      for (std::size_t i = 0; i < y.size(); ++i) radiance += light[i] * y[i];
      expected +=
          weight / 2 * 2 * kPi / 48 * (exponent + 1) / (2 * kPi) * std::pow(cosine, exponent) * radiance;
    }
  std::vector<double> row(light.size());
  lobeRow(phongKernel(order, exponent), eye, row);
  double sum = 0;
  for (std::size_t i = 0; i < row.size(); ++i) sum += row[i] * light[i];
  EXPECT_NEAR(sum, expected, 1e-12);
}

TEST(LobeRow, ReflectsAlikeOnBothSides) {
  std::vector<double> above(9), below(9);
  lobeRow(phongKernel(3, 20), Vec3(0.6, 0, 0.8), above);
  lobeRow(phongKernel(3, 20), Vec3(0.6, 0, -0.8), below);
  EXPECT_EQ(above, below);
  std::vector<double> short_row(8);
  EXPECT_THROW(lobeRow(phongKernel(3, 20), Vec3(0, 0, 1), short_row), std::invalid_argument);
}

formats::BrdfTable someTable(int order, int angles) {
  formats::BrdfTable table;
  table.order = order;
  table.angles = angles;
  for (int angle = 0; angle < angles; ++angle)
    for (int channel = 0; channel < 3; ++channel)
      for (int l = 0; l < order; ++l)
        for (int m = -l; m <= l; ++m)
          table.values.push_back(m < 0 ? 0
                                       : static_cast<float>(std::cos(angle + 3 * channel + 5 * l + 7 * m)));
  return table;
}

TEST(TableRows, TurnsTheRowByTheEyesAzimuth) {
  const int order = 6;
  const formats::BrdfTable table = someTable(order, 9);
  for (const double azimuth : {0.0, 0.4, 1.9, -2.5}) {
    const double z = 3.0 / 8;  // the fourth row of the table, exactly
    const double sine = std::sqrt(1 - z * z);
    std::vector<double> rows(3 * coefficientCount(order));
    tableRows(table, Vec3(sine * std::cos(azimuth), sine * std::sin(azimuth), z), order, rows);
    const ShRotation turn(order, Eigen::AngleAxisd(azimuth, Vec3::UnitZ()).toRotationMatrix());
    for (int channel = 0; channel < 3; ++channel) {
      std::vector<double> source(coefficientCount(order)), expected(source.size());
      for (std::size_t i = 0; i < source.size(); ++i)
        source[i] = table.values[(3 * 3 + channel) * source.size() + i];
      turn.apply(std::span<const double>(source), std::span<double>(expected));
      for (std::size_t i = 0; i < source.size(); ++i)
        EXPECT_NEAR(rows[channel * source.size() + i], expected[i], 1e-12);
    }
  }
}

TEST(TableRows, InterpolatesAnglesAndLeavesFurtherBandsOut) {
  const formats::BrdfTable table = someTable(4, 5);
  std::vector<double> low(12), high(12), between(12);
  tableRows(table, Vec3(std::sqrt(1 - 0.25 * 0.25), 0, 0.25), 2, low);
  tableRows(table, Vec3(std::sqrt(1 - 0.5 * 0.5), 0, -0.5), 2, high);
  tableRows(table, Vec3(std::sqrt(1 - 0.4 * 0.4), 0, 0.4), 2, between);
  for (std::size_t i = 0; i < between.size(); ++i)
    EXPECT_NEAR(between[i], 0.4 * low[i] + 0.6 * high[i], 1e-12);
  EXPECT_NEAR(low[2], table.values[(1 * 3 + 0) * 16 + 2], 1e-12);

  std::vector<double> at_zenith(12);
  tableRows(table, Vec3(0, 0, 1), 2, at_zenith);
  EXPECT_NEAR(at_zenith[0], table.values[4 * 3 * 16], 1e-12);
  EXPECT_THROW(tableRows(table, Vec3(0, 0, 1), 5, at_zenith), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::transport
