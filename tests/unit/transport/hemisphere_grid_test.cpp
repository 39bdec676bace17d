#include "transport/hemisphere_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace bakelight::transport {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

TEST(HemisphereGrid, AxesAndZenith) {
  EXPECT_TRUE(hemisphereFromSquare(0.5, 0.5).isApprox(Vec3(0, 0, 1)));
  EXPECT_TRUE(hemisphereFromSquare(1, 0.5).isApprox(Vec3(1, 0, 0)));
  EXPECT_TRUE(hemisphereFromSquare(0.5, 1).isApprox(Vec3(0, 1, 0)));
  EXPECT_TRUE(hemisphereFromSquare(0, 0.5).isApprox(Vec3(-1, 0, 0)));
  EXPECT_TRUE(hemisphereFromSquare(0.5, 0).isApprox(Vec3(0, -1, 0)));
  EXPECT_TRUE(hemisphereFromSquare(1, 1).isApprox(Vec3(1, 1, 0).normalized()));
}

TEST(HemisphereGrid, InverseIsExact) {
  constexpr int kSide = 41;
  for (int row = 0; row <= kSide; ++row)
    for (int column = 0; column <= kSide; ++column) {
      const double a = column / double{kSide}, b = row / double{kSide};
      const Vec3 direction = hemisphereFromSquare(a, b);
      EXPECT_NEAR(direction.norm(), 1, 1e-14);
      EXPECT_GE(direction.z(), 0);
      const SquarePoint point = squareFromHemisphere(3 * direction);
      EXPECT_NEAR(point.a, a, 1e-13);
      EXPECT_NEAR(point.b, b, 1e-13);
    }
}

// Equal areas: midpoints integrate with equal weights what varies over the hemisphere.
TEST(HemisphereGrid, CellsHaveEqualSolidAngles) {
  constexpr int kSide = 256;
  double cosine = 0, squared = 0;
  Vec3 mean = Vec3::Zero();
  for (int row = 0; row < kSide; ++row)
    for (int column = 0; column < kSide; ++column) {
      const Vec3 direction = hemisphereCell(kSide, column, row);
      cosine += direction.z();
      squared += direction.x() * direction.x();
      mean += direction;
    }
  const double weight = 2 * std::numbers::pi / (kSide * kSide);
  EXPECT_NEAR(cosine * weight, std::numbers::pi, 1e-4);
  EXPECT_NEAR(squared * weight, 2 * std::numbers::pi / 3, 1e-4);
  EXPECT_NEAR(mean.x() * weight, 0, 1e-12);
  EXPECT_NEAR(mean.y() * weight, 0, 1e-12);
}

// The figure that a grid of 8 × 8 is known by.
TEST(HemisphereGrid, EightByEightSpansTenToSeventySixDegrees) {
  EXPECT_NEAR(std::acos(hemisphereCell(8, 4, 4).z()) * kDegrees, 10.1, 0.1);
  EXPECT_NEAR(std::acos(hemisphereCell(8, 7, 4).z()) * kDegrees, 76.5, 0.1);
}

TEST(HemisphereGrid, PositionsAreCellsAtTheirMiddlesAndClampAtTheHorizon) {
  for (int row = 0; row < 8; ++row)
    for (int column = 0; column < 8; ++column) {
      const GridPosition at = gridPosition(8, hemisphereCell(8, column, row));
      EXPECT_NEAR(at.column + double{at.across}, column, 1e-5);
      EXPECT_NEAR(at.row + double{at.up}, row, 1e-5);
    }
  const GridPosition horizon = gridPosition(8, Vec3(1, 0, 0)), below = gridPosition(8, Vec3(1, 0, -1));
  EXPECT_EQ(horizon.column + double{horizon.across}, 7);
  EXPECT_EQ(below.column + double{below.across}, 7);
  EXPECT_EQ(gridPosition(1, Vec3(1, 0, 0)).column, 0);
}

}  // namespace
}  // namespace bakelight::transport
