#include "transport/windowing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "transport/directions.h"

namespace bakelight::transport {
namespace {

double leastOverMean(const ShLight& light, int order) {
  double least = std::numeric_limits<double>::infinity(), mean = 0;
  const auto lattice = sphereDirections(20000);
  for (const Vec3& direction : lattice) {
    const auto basis = evaluateSh(order, direction);
    double value = 0;
    for (std::size_t i = 0; i < basis.size(); ++i) value += luminance(light[i]) * basis[i];
    least = std::min(least, value);
    mean += value / static_cast<double>(lattice.size());
  }
  return least / mean;
}

TEST(Windowing, LeavesTheMeanAndScalesBandsByTheWindow) {
  const ShLight light(coefficientCount(4), Float3{1, 2, 4});
  const WindowedLight windowed = window(light, 0.01);
  EXPECT_EQ(windowed.light[0], light[0]);
  for (int l = 1; l < 4; ++l)
    for (int m = -l; m <= l; ++m)
      EXPECT_FLOAT_EQ(windowed.light[coefficientIndex(l, m)][1],
                      static_cast<float>(2 / (1 + 0.01 * l * l * (l + 1) * (l + 1))));
  // By hand: bands of 3, 5, 7 equal coefficients, factors 1/1.04, 1/1.36, 1/2.44.
  const double kept = 3 / (1.04 * 1.04) + 5 / (1.36 * 1.36) + 7 / (2.44 * 2.44);
  EXPECT_NEAR(windowed.moved_energy, 1 - kept / 15, 1e-7);
}

TEST(Windowing, NothingMovesWithoutAWindow) {
  const ShLight light = diskLight(6, Vec3::UnitY(), 0.1, {1, 2, 3});
  const WindowedLight windowed = window(light, 0);
  EXPECT_EQ(windowed.light, light);
  EXPECT_EQ(windowed.moved_energy, 0);
  EXPECT_EQ(window(uniformLight(5, {1, 1, 1}), 3).moved_energy, 0);
}

TEST(Windowing, MovedEnergyGrowsWithTheStrength) {
  const ShLight light = diskLight(8, Vec3(1, 2, 2) / 3, 0.2, {5, 4, 3});
  double before = 0;
  for (double lambda = 1e-6; lambda < 1e6; lambda *= 3) {
    const double moved = window(light, lambda).moved_energy;
    EXPECT_GT(moved, before) << lambda;
    EXPECT_LE(moved, 1);
    before = moved;
  }
  EXPECT_GT(before, 0.999);
}

TEST(Windowing, RefusesNegativeStrengthAndOddSizes) {
  EXPECT_THROW(window(uniformLight(3, {1, 1, 1}), -1), std::invalid_argument);
  EXPECT_THROW(window(ShLight(5), 1), std::invalid_argument);
  EXPECT_THROW(windowUntilPositive(ShLight{}), std::invalid_argument);
}

TEST(WindowUntilPositive, StopsAtTheLeastStrengthThatSuffices) {
  const double tolerance = 0.02;
  for (const int order : {2, 3, 5, 10}) {
    const ShLight light = diskLight(order, Vec3(2, -1, 2) / 3, 0.05, {3, 3, 2});
    ASSERT_LT(leastOverMean(light, order), -0.3);
    const WindowedLight windowed = windowUntilPositive(light, tolerance);
    // Another lattice than the library's: a little slack.
    EXPECT_NEAR(leastOverMean(windowed.light, order), -tolerance, 2e-3) << order;
    EXPECT_LT(leastOverMean(window(light, windowed.lambda * 0.9).light, order), -tolerance);
    EXPECT_GT(windowed.moved_energy, 0.01);
    EXPECT_LT(windowed.moved_energy, 1);
  }
}

TEST(WindowUntilPositive, LeavesPositiveLightAlone) {
  const ShLight light = diskLight(5, Vec3::UnitX(), 3.0, {1, 1, 1});  // nearly uniform
  ASSERT_GT(leastOverMean(light, 5), 0);
  const WindowedLight windowed = windowUntilPositive(light);
  EXPECT_EQ(windowed.lambda, 0);
  EXPECT_EQ(windowed.light, light);
}

TEST(WindowUntilPositive, DoesNotDependOnBrightness) {
  const ShLight light = diskLight(6, Vec3::UnitZ(), 0.3, {1, 0.5F, 0.2F});
  const double lambda = windowUntilPositive(light).lambda;
  EXPECT_GT(lambda, 0);
  EXPECT_NEAR(windowUntilPositive(scaled(light, 1024)).lambda, lambda, 1e-9 * lambda);
}

TEST(WindowUntilPositive, TamesASunOfAMillionOverASkyOfOne) {
  for (const int order : {1, 5, 10}) {
    const ShLight light =
        sum(uniformLight(order, {1, 1, 1}),
            diskLight(order, Vec3(0, 0.8, 0.6), 0.265 * 3.14159265 / 180, {1e6F, 1e6F, 1e6F}));
    const WindowedLight windowed = windowUntilPositive(light);
    for (const Float3& coefficient : windowed.light)
      for (const float value : coefficient) ASSERT_TRUE(std::isfinite(value));
    EXPECT_EQ(windowed.light[0], light[0]);
    if (order > 1) {
      EXPECT_GE(leastOverMean(windowed.light, order), -0.0201);
      EXPECT_GT(windowed.moved_energy, 0.1);
      EXPECT_LT(windowed.moved_energy, 1);
    }
  }
}

TEST(WindowUntilPositive, NoLightStaysNone) {
  const ShLight dark(coefficientCount(5), Float3{0, 0, 0});
  EXPECT_EQ(windowUntilPositive(dark).light, dark);
  EXPECT_EQ(windowUntilPositive(dark).moved_energy, 0);
}

TEST(Windowing, LoudRingingIsToldWithARemedyThatIsLeft) {
  EXPECT_EQ(ringingWarning(0.5, 0), "");
  EXPECT_EQ(ringingWarning(0, 0), "");
  const std::string plain = ringingWarning(-3, 0), windowed = ringingWarning(-3, 0.01);
  EXPECT_NE(plain.find("falls to -3 times its mean"), std::string::npos) << plain;
  EXPECT_NE(plain.find("\"windowing\": 0.01, or \"auto\""), std::string::npos) << plain;
  EXPECT_NE(windowed.find("a stronger \"windowing\""), std::string::npos) << windowed;
}

}  // namespace
}  // namespace bakelight::transport
