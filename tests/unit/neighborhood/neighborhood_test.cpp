// A ball over a plane and in space: closed forms, furnace, what is far away.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "tests/unit/neighborhood/made_neighborhood.h"
#include "transport/directions.h"
#include "transport/neighborhood_shading.h"

namespace bakelight {
namespace {

using formats::Float3;
using tests::groundOf;
using tests::standingBall;
using tests::unshadowedLight;
using tests::volumeOf;
using transport::Vec3;
using transport::vec3;

constexpr int kOrder = 5;
constexpr Float3 kWhite = {1, 1, 1}, kBlack = {0, 0, 0};

// (1/π) ∫ kernel(s) · L(s) over directions that do not meet the unit ball around `center`.
template <class Kernel>
double radiosityBeside(const Vec3& center, const Vec3& point, std::span<const Float3> light,
                       const Kernel& kernel) {
  static const std::vector<Vec3> directions = transport::sphereDirections(60000);
  const Vec3 way = center - point;
  const double distance = way.norm(), edge = std::sqrt(std::max(0.0, 1 - 1 / (distance * distance)));
  const Vec3 axis = way / distance;
  double sum = 0;
  for (const Vec3& s : directions) {
    const double weight = kernel(s);
    if (weight == 0 || axis.dot(s) > edge) continue;
    const std::vector<double> basis = transport::evaluateSh(kOrder, s);
    double radiance = 0;
    for (std::size_t i = 0; i < basis.size(); ++i) radiance += basis[i] * static_cast<double>(light[i][0]);
    sum += weight * radiance;
  }
  return sum * 4 / static_cast<double>(directions.size());
}

TEST(GroundTransfer, OfABlackBallUnderAnEvenSkyIsItsFormFactor) {
  const formats::TriangleMesh ball = standingBall();
  const formats::Neighborhood made = groundOf(ball, unshadowedLight(ball, kOrder, kBlack));
  transport::GroundShading ground(made);
  ground.setLight(transport::uniformLight(kOrder, {1, 1, 1}), {});
  for (const float x : made.ground->x)
    for (const float z : made.ground->z) {
      const Vec3 way(x, 1, z);
      if (std::hypot(x, z) < 0.2F) continue;  // almost below the ball, where its facets count
      // R² h / D³ (a sphere above the horizon, seen from a plane).
      EXPECT_NEAR(ground.radiosityAt(x, z)[0], 1 - std::pow(way.norm(), -3), 3e-3) << x << ", " << z;
    }
}

TEST(GroundTransfer, OfABlackBallUnderADiskIsTheLightThatPassesIt) {
  const formats::TriangleMesh ball = standingBall();
  const formats::Neighborhood made = groundOf(ball, unshadowedLight(ball, kOrder, kBlack));
  transport::GroundShading ground(made);
  const transport::ShLight light =
      transport::diskLight(kOrder, Vec3(0.5, 1, 0.3).normalized(), 0.5, {3, 2, 1});
  ground.setLight(light, {});
  const auto cosine = [](const Vec3& s) { return std::max(0.0, s.y()); };
  double darkest = 10, open = 0;
  for (std::size_t i = 0; i < made.ground->x.size(); i += 5)
    for (std::size_t k = 0; k < made.ground->z.size(); k += 5) {
      const Vec3 point(made.ground->x[i], 0, made.ground->z[k]);
      if (point.norm() < 0.2) continue;
      const double expected = radiosityBeside({0, 1, 0}, point, light, cosine);
      const double found = ground.radiosityAt(point.x(), point.z())[0];
      EXPECT_NEAR(found, expected, 4e-3) << point.transpose();
      darkest = std::min(darkest, found), open = std::max(open, found);
    }
  EXPECT_LT(darkest, open / 3);  // there is a shadow
}

// A white body under an even sky looks like that sky: it can't be told that it is there.
TEST(GroundTransfer, FurnaceAWhiteBallCastsNoShadowUnderAnEvenSky) {
  const formats::TriangleMesh ball = standingBall(4);
  const formats::Neighborhood made = groundOf(ball, unshadowedLight(ball, kOrder, kWhite));
  transport::GroundShading ground(made);
  ground.setLight(transport::uniformLight(kOrder, {1, 1, 1}), {});
  for (const float x : made.ground->x)
    for (const float z : made.ground->z) {
      if (std::hypot(x, z) < 0.2F) continue;
      for (const float radiosity : ground.radiosityAt(x, z))
        EXPECT_NEAR(radiosity, 1, 1e-4) << x << ", " << z;
    }
}

TEST(GroundTransfer, AColoredBallColorsTheGroundByItsAlbedo) {
  const formats::TriangleMesh ball = standingBall(4);
  const formats::Neighborhood made = groundOf(ball, unshadowedLight(ball, kOrder, {1, 0.25F, 0}));
  EXPECT_EQ(made.channels, 3);
  transport::GroundShading ground(made);
  ground.setLight(transport::uniformLight(kOrder, {1, 1, 1}), {});
  const Float3 radiosity = ground.radiosityAt(1, 0);
  const double shadow = 1 / std::pow(2.0, 1.5);
  EXPECT_NEAR(radiosity[0], 1, 2e-3);
  EXPECT_NEAR(radiosity[1], 1 - 0.75 * shadow, 1e-2);  // linear between points
  EXPECT_NEAR(radiosity[2], 1 - shadow, 1e-2);
}

TEST(GroundTransfer, BelowAFlatBaseIsDark) {
  formats::TriangleMesh half = tests::icosphere(4);
  for (std::size_t v = 0; v < half.vertexCount(); ++v)
    if (half.positions[v][1] < 0) half.positions[v][1] = 0, half.normals[v] = {0, -1, 0};
  const formats::Neighborhood made = groundOf(half, unshadowedLight(half, kOrder, kWhite), 16, 1, 512);
  transport::GroundShading ground(made);
  ground.setLight(transport::uniformLight(kOrder, {1, 1, 1}), {});
  for (const float x : made.ground->x)
    if (std::abs(x) < 0.6F) {
      EXPECT_NEAR(ground.radiosityAt(x, 0)[0], 0, 5e-3) << x;
    }
  EXPECT_NEAR(ground.radiosityAt(made.ground->x.back(), 0)[0], 1, 1e-4);
}

TEST(GroundTransfer, FarAwayTheObjectChangesNothing) {
  const formats::TriangleMesh ball = standingBall(3);
  const formats::Neighborhood made = groundOf(ball, unshadowedLight(ball, kOrder, kBlack), 24, 30);
  transport::GroundShading ground(made);
  const transport::ShLight light = transport::diskLight(kOrder, Vec3(0.2, 1, 0).normalized(), 0.7, {1, 1, 1});
  ground.setLight(light, {});
  const auto x = static_cast<double>(made.ground->x.back());
  EXPECT_GT(x, 30);
  const std::vector<double> factors = transport::clampedCosineFactors(kOrder),
                            up = transport::evaluateSh(kOrder, Vec3::UnitY());
  double open = 0;
  for (int l = 0; l < kOrder; ++l)
    for (int i = l * l; i < (l + 1) * (l + 1); ++i)
      open += factors[static_cast<std::size_t>(l)] * up[static_cast<std::size_t>(i)] / std::numbers::pi *
              static_cast<double>(light[static_cast<std::size_t>(i)][0]);
  EXPECT_NEAR(ground.radiosityAt(x, 0)[0], open, 1e-4 * open);
  EXPECT_EQ(ground.radiosityAt(x, 0), ground.radiosityAt(10 * x, 0));
  EXPECT_EQ(ground.seen({0, -5, 0}, -Vec3::UnitY(), kWhite)[3], 0);
  EXPECT_EQ(ground.seen({0, 5, 0}, Vec3(x, -5, 0).normalized(), kWhite)[3], 0);
}

TEST(GroundTransfer, IsTheSameWithAnyNumberOfThreads) {
  const formats::TriangleMesh ball = standingBall(3);
  const neighborhood::Emitted emitted = unshadowedLight(ball, kOrder, kWhite);
  const formats::Neighborhood all = groundOf(ball, emitted, 12, 2, 256);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(groundOf(ball, emitted, 12, 2, 256).ground->vectors.decode(), all.ground->vectors.decode());
}

TEST(VolumeTransfer, OfABlackBallIsTheLightThatPassesItAsADiffuseReceiverNeedsIt) {
  const formats::TriangleMesh ball = standingBall();
  const formats::Neighborhood made = volumeOf(ball, unshadowedLight(ball, kOrder, kBlack), 8, 1.5, 8192);
  transport::VolumeShading volume(made);
  const transport::ShLight light =
      transport::diskLight(kOrder, Vec3(0.5, 1, 0.3).normalized(), 0.5, {3, 2, 1});
  volume.setLight(light, {});
  const auto& axes = made.volume->axes;
  const Vec3 point(axes[0][2], axes[1][1], axes[2][3]);
  const std::vector<double> factors = transport::clampedCosineFactors(kOrder);
  double largest = 0;
  for (const Vec3& normal : transport::sphereDirections(20)) {
    // The clamped cosine in the bands that are kept.
    const std::vector<double> of_normal = transport::evaluateSh(kOrder, normal);
    const auto kernel = [&](const Vec3& s) {
      const std::vector<double> basis = transport::evaluateSh(kOrder, s);
      double sum = 0;
      for (int l = 0; l < kOrder; ++l)
        for (int i = l * l; i < (l + 1) * (l + 1); ++i)
          sum += factors[static_cast<std::size_t>(l)] * of_normal[static_cast<std::size_t>(i)] *
                 basis[static_cast<std::size_t>(i)];
      return sum;
    };
    const double expected = radiosityBeside({0, 1, 0}, point, light, kernel);
    EXPECT_NEAR(volume.radiosityAt(point, normal)[0], expected, 4e-3) << normal.transpose();
    largest = std::max(largest, expected);
  }
  EXPECT_GT(largest, 0.3);
}

TEST(VolumeTransfer, FacingABlackBallAReceiverLosesItsFormFactor) {
  const formats::TriangleMesh ball = standingBall(4);
  const formats::Neighborhood made = volumeOf(ball, unshadowedLight(ball, kOrder, kBlack), 8, 1.5, 4096);
  transport::VolumeShading volume(made);
  volume.setLight(transport::uniformLight(kOrder, {1, 1, 1}), {});
  const Vec3 point(made.volume->axes[0][1], made.volume->axes[1][2], made.volume->axes[2][2]);
  const Vec3 way = Vec3(0, 1, 0) - point;
  EXPECT_NEAR(volume.radiosityAt(point, way.normalized())[0], 1 - 1 / way.squaredNorm(), 0.02);
  EXPECT_NEAR(volume.radiosityAt(point, -way.normalized())[0], 1, 0.02);
}

TEST(VolumeTransfer, FurnaceAWhiteBallChangesNothingUnderAnEvenSky) {
  const formats::TriangleMesh ball = standingBall(4);
  std::uint64_t inside = 0;
  transport::VolumeShading volume(
      volumeOf(ball, unshadowedLight(ball, kOrder, kWhite), 12, 1, 1024, &inside));
  volume.setLight(transport::uniformLight(kOrder, {1, 1, 1}), {});
  EXPECT_GT(inside, 10U);
  // Also close to the surface, where points within are interpolated with.
  for (const Vec3& s : transport::sphereDirections(50)) {
    const Vec3 point = Vec3(0, 1, 0) + 1.05 * s;
    EXPECT_NEAR(volume.radiosityAt(point, s)[0], 1, 5e-3) << s.transpose();
  }
}

TEST(VolumeTransfer, GoesOverIntoTheLightsOwnWhereTheGridEnds) {
  const formats::TriangleMesh ball = standingBall(3);
  const formats::Neighborhood made = volumeOf(ball, unshadowedLight(ball, kOrder, kBlack), 8, 1, 256);
  transport::VolumeShading volume(made);
  volume.setLight(transport::uniformLight(kOrder, {1, 1, 1}), {});
  const auto& x = made.volume->axes[0];
  const auto at = [&](double place) { return volume.radiosityAt({place, 1, 0}, -Vec3::UnitX())[0]; };
  const auto edge = static_cast<double>(x.back());
  EXPECT_FLOAT_EQ(at(edge), at(edge + 5));
  EXPECT_NEAR(at(edge - 1e-6), at(edge + 1e-6), 1e-5);
  EXPECT_LT(at(static_cast<double>(x[x.size() - 2])), at(edge) - 0.05F);
  // Nothing is below the plane: the lowest points count on.
  EXPECT_EQ(volume.radiosityAt({1.5, 0, 0}, Vec3::UnitY()),
            volume.radiosityAt({1.5, -0.2, 0}, Vec3::UnitY()));
}

TEST(GradedAxis, EndsWhereItShouldAndGrowsEvenly) {
  for (const double reach : {0.1, 3.0, 50.0}) {
    const std::vector<float> axis = neighborhood::gradedAxis(-1, 2, 6, 4, reach);
    ASSERT_EQ(axis.size(), 15U);
    EXPECT_NEAR(axis.front(), -1 - reach, 1e-4 * reach);
    EXPECT_NEAR(axis.back(), 2 + reach, 1e-4 * reach);
    for (std::size_t i = 1; i < axis.size(); ++i) EXPECT_LT(axis[i - 1], axis[i]);
    EXPECT_NEAR((axis[13] - axis[12]) / (axis[12] - axis[11]), (axis[14] - axis[13]) / (axis[13] - axis[12]),
                1e-3);
  }
}

}  // namespace
}  // namespace bakelight
