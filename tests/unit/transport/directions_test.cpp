#include "transport/directions.h"

#include <gtest/gtest.h>

#include <numbers>

#include "transport/sh.h"

namespace bakelight::transport {
namespace {

TEST(SphereDirections, AreUnitAndIntegrateTheBasis) {
  const int count = 4096;
  const std::vector<Vec3> directions = sphereDirections(count);
  ASSERT_EQ(directions.size(), static_cast<std::size_t>(count));
  std::vector<double> mean(coefficientCount(10), 0.0);
  for (const Vec3& d : directions) {
    EXPECT_NEAR(d.norm(), 1, 1e-14);
    const std::vector<double> values = evaluateSh(10, d);
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += values[i] / count;
  }
  // ∫ y_i vanishes for i > 0. A random set of this size would leave 1/√4096 · 0.28 = 4e-3.
  for (std::size_t i = 1; i < mean.size(); ++i) EXPECT_NEAR(mean[i], 0, 5e-5) << "coefficient " << i;
}

TEST(SphereDirections, NeighborsInTheListAreNeighborsOnTheSphere) {
  const int count = 4096;
  const std::vector<Vec3> directions = sphereDirections(count);
  double total_angle = 0;
  for (int i = 1; i < count; ++i)
    total_angle += std::acos(std::clamp(directions[i].dot(directions[i - 1]), -1.0, 1.0));
  const double spacing = std::sqrt(4 * std::numbers::pi / count);
  EXPECT_LT(total_angle / (count - 1), 1.6 * spacing);
}

TEST(SphereDirections, WorkForFewAndMany) {
  EXPECT_EQ(sphereDirections(1).size(), 1u);
  EXPECT_EQ(sphereDirections(64).size(), 64u);
  EXPECT_EQ(sphereDirections(100000).size(), 100000u);
}

}  // namespace
}  // namespace bakelight::transport
