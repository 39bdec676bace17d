#include "tools/atlas/flatten/untangling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "flat_shapes.h"
#include "tools/atlas/charts/stretch.h"
#include "tools/atlas/flatten/flattening.h"
#include "tools/atlas/flatten/free_boundary.h"
#include "tools/atlas/flatten/guided_start.h"
#include "tools/atlas/flatten/injectivity.h"

namespace bakelight::atlas {
namespace {

using tests::wholeChart;

constexpr std::uint32_t kSide = 12;

// Unit squares, cut in two, but those that `isLeftOut`.
template <class IsLeftOut>
formats::TriangleMesh squares(std::uint32_t columns, std::uint32_t rows, const IsLeftOut& isLeftOut) {
  formats::TriangleMesh mesh;
  for (std::uint32_t j = 0; j <= rows; ++j)
    for (std::uint32_t i = 0; i <= columns; ++i)
      mesh.positions.push_back({static_cast<float>(i), static_cast<float>(j), 0});
  for (std::uint32_t j = 0; j < rows; ++j)
    for (std::uint32_t i = 0; i < columns; ++i) {
      if (isLeftOut(i, j)) continue;
      const std::uint32_t a = j * (columns + 1) + i;
      mesh.triangles.push_back({a, a + 1, a + columns + 2});
      mesh.triangles.push_back({a, a + columns + 2, a + columns + 1});
    }
  return mesh;
}

constexpr auto kNoneLeftOut = [](std::uint32_t, std::uint32_t) { return false; };

// Flat as it is; places are in units of the squares, from the lower left corner.
struct Plate {
  explicit Plate(const formats::TriangleMesh& mesh) : chart(wholeChart(mesh)) {
    unit = std::sqrt(2 * chart.area / static_cast<double>(chart.triangles.size()));
    Vec2 corner = chart.positions[0].head<2>();
    for (const Vec3& p : chart.positions) corner = corner.cwiseMin(p.head<2>());
    for (const Vec3& p : chart.positions) plane.emplace_back(p.head<2>() - corner);
  }
  Vec2& at(double x, double y) {
    const Vec2 place = unit * Vec2(x, y);
    Vec2& nearest = *std::min_element(plane.begin(), plane.end(), [&](const Vec2& a, const Vec2& b) {
      return (a - place).squaredNorm() < (b - place).squaredNorm();
    });
    EXPECT_LT((nearest - place).norm(), 1e-3 * unit);
    return nearest;
  }
  double l2() const {
    std::vector<Vec2> scaled = plane;
    scaleForLeastStretch(chart, scaled);
    return stretchOf(chart, scaled).l2();
  }

  Chart chart;
  double unit;
  std::vector<Vec2> plane;
};

TEST(Untangle, TurnsFlippedTrianglesBackAndSharesWhatWasSqueezed) {
  Plate plate(squares(kSide, kSide, kNoneLeftOut));
  ASSERT_NEAR(plate.l2(), 1, 1e-6);
  plate.at(6, 6) += plate.unit * Vec2(1.7, 0.4);
  ASSERT_GT(badTriangles(plate.chart, plate.plane).count(), 0);
  EXPECT_TRUE(untangle(plate.chart, plate.plane));
  EXPECT_EQ(badTriangles(plate.chart, plate.plane).count(), 0);
  EXPECT_LT(plate.l2(), 1.01);
}

TEST(Untangle, LeavesMoreThanAFewAlone) {
  Plate plate(squares(kSide, kSide, kNoneLeftOut));
  for (Vec2& p : plate.plane) p.x() = std::min(p.x(), 11 * plate.unit - p.x());  // folded over
  const std::vector<Vec2> before = plate.plane;
  EXPECT_FALSE(untangle(plate.chart, plate.plane));
  EXPECT_EQ(plate.plane, before);
}

TEST(UncrossBorders, OpensANotchWhoseMouthHasClosed) {
  Plate plate(squares(kSide, kSide, [](std::uint32_t i, std::uint32_t j) { return i == 6 && j >= 10; }));
  plate.at(6, 12).x() += 0.7 * plate.unit;
  plate.at(7, 12).x() -= 0.7 * plate.unit;
  ASSERT_EQ(badTriangles(plate.chart, plate.plane).count(), 0);
  ASSERT_TRUE(bordersCross(plate.chart, plate.plane));
  EXPECT_TRUE(uncrossBorders(plate.chart, plate.plane));
  EXPECT_TRUE(isInjective(plate.chart, plate.plane));
  EXPECT_LT(plate.l2(), 1.15);
}

TEST(UncrossBorders, TurnsSmallHolesTheRightWay) {
  Plate plate(squares(kSide, kSide, [](std::uint32_t i, std::uint32_t j) { return i == 6 && j == 6; }));
  ASSERT_EQ(plate.chart.borders.size(), 2u);
  const std::vector<Vec2> flat = plate.plane;
  // Two opposite corners of the hole past each other, which turns it inside out.
  plate.at(6, 6) += 0.6 * plate.unit * Vec2(1, 1);
  plate.at(7, 7) -= 0.6 * plate.unit * Vec2(1, 1);
  ASSERT_EQ(badTriangles(plate.chart, plate.plane).count(), 0);
  ASSERT_FALSE(isInjective(plate.chart, plate.plane));
  EXPECT_TRUE(uncrossBorders(plate.chart, plate.plane));
  EXPECT_TRUE(isInjective(plate.chart, plate.plane));
  EXPECT_LT(plate.l2(), 1.05);
}

// A hole that is open exactly, and closed on the next grid: floats would turn it inside out when the atlas is
// packed.
TEST(UncrossBorders, WidensHolesThatRoundingWouldClose) {
  Plate plate(squares(kSide, kSide, [](std::uint32_t i, std::uint32_t j) { return i == 6 && j == 6; }));
  const double width = 1e-8;
  plate.at(6, 6) += plate.unit * Vec2(0.5 - width, 0.5 - width);
  plate.at(7, 7) -= plate.unit * Vec2(0.5 - width, 0.5 - width);
  ASSERT_TRUE(isInjective(plate.chart, plate.plane));
  ASSERT_FALSE(survivesRounding(plate.chart, plate.plane));
  EXPECT_TRUE(uncrossBorders(plate.chart, plate.plane));
  EXPECT_TRUE(isInjective(plate.chart, plate.plane));
  EXPECT_TRUE(survivesRounding(plate.chart, plate.plane));
}

TEST(UncrossBorders, LeavesPartsThatLieOnEachOtherAlone) {
  Plate plate(squares(60, 2, kNoneLeftOut));
  for (Vec2& p : plate.plane) {
    const double angle = 2.4 * std::numbers::pi * p.x() / (60 * plate.unit), radius = 8 * plate.unit - p.y();
    p = {radius * std::cos(angle), radius * std::sin(angle)};
  }
  ASSERT_EQ(badTriangles(plate.chart, plate.plane).count(), 0);
  const std::vector<Vec2> before = plate.plane;
  EXPECT_FALSE(uncrossBorders(plate.chart, plate.plane));
  EXPECT_EQ(plate.plane, before);
}

// Half of the plate turned against the other half, as two charts have it.
TEST(GuidedStart, JoinsPlanesThatAreTurned) {
  const formats::TriangleMesh mesh = squares(kSide, kSide, kNoneLeftOut);
  const Surface surface = surfaceOf(mesh, "made.ply");
  std::vector<std::uint32_t> all(surface.triangleCount());
  std::iota(all.begin(), all.end(), 0u);
  const Chart chart = chartOf(surface, all);
  const std::vector<Vec2> directions = directionsIn(chart, projectedAlong(chart, Vec3::UnitZ()));
  Guides guides;
  guides.directions.resize(all.size());
  guides.planes.assign(all.size(), -1);
  EXPECT_FALSE(guidedStart(surface, chart, guides).has_value());
  const Eigen::Rotation2Dd turn(2.0);
  for (const std::uint32_t t : all) {
    guides.planes[t] = t < all.size() / 2 ? 3 : 8;
    guides.directions[t] = t < all.size() / 2 ? directions[t] : Vec2(turn * directions[t]);
  }
  const auto plane = guidedStart(surface, chart, guides);
  ASSERT_TRUE(plane.has_value());
  EXPECT_TRUE(isInjective(chart, *plane));
  EXPECT_NEAR(stretchOf(chart, *plane).l2(), 1, 1e-9);
}

// The same half of a tube with 4 times the triangles: unrolled by the directions of the coarser one.
TEST(GuidedStart, TakesDirectionsFromACoarserSurface) {
  const auto halfTube = [](std::uint32_t divisions) {
    formats::TriangleMesh mesh = squares(divisions, divisions, kNoneLeftOut);
    for (formats::Float3& p : mesh.positions) {
      const double angle = std::numbers::pi * p[0] / divisions;
      p = {static_cast<float>(-std::cos(angle)), p[1] / static_cast<float>(divisions),
           static_cast<float>(std::sin(angle))};
    }
    return mesh;
  };
  const Surface coarse = surfaceOf(halfTube(16), "coarse.ply"), fine = surfaceOf(halfTube(32), "fine.ply");
  const auto allOf = [](const Surface& surface) {
    std::vector<std::uint32_t> all(surface.triangleCount());
    std::iota(all.begin(), all.end(), 0u);
    return all;
  };
  const Flattening flattening = flatten(coarse, allOf(coarse), {});
  ASSERT_TRUE(flattening.piece.has_value());
  const auto centroid = [](const Surface& surface, std::uint32_t t) {
    return Vec3((surface.corner(t, 0) + surface.corner(t, 1) + surface.corner(t, 2)) / (3 * surface.scale));
  };
  Guides guides;
  guides.planes.assign(fine.triangleCount(), 0);
  for (const std::uint32_t t : allOf(fine)) {
    std::uint32_t nearest = 0;
    for (const std::uint32_t c : allOf(coarse))
      if ((centroid(coarse, c) - centroid(fine, t)).norm() <
          (centroid(coarse, nearest) - centroid(fine, t)).norm())
        nearest = c;
    guides.directions.push_back(directionBeside(fine, t, coarse, nearest, flattening.directions[nearest]));
  }
  const Chart chart = chartOf(fine, allOf(fine));
  const auto plane = guidedStart(fine, chart, guides);
  ASSERT_TRUE(plane.has_value());
  EXPECT_TRUE(isInjective(chart, *plane));
  EXPECT_NEAR(stretchOf(chart, *plane).l2(), 1, 2e-3);
}

}  // namespace
}  // namespace bakelight::atlas
