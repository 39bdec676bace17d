// The ground of the path tracer: closed forms, and neighborhood transfer against it.
#include "tools/reference/ground.h"

#include <gtest/gtest.h>

#include "formats/error.h"
#include "tests/unit/neighborhood/made_neighborhood.h"
#include "tests/unit/reference/scenes.h"
#include "transport/lighting.h"

namespace bakelight::reference {
namespace {

using namespace bakelight::tests;

// Irradiance ÷ π of the ground at a point, by its radiance at albedo 1.
BatchMeans radiosityAt(const TriangleMesh& mesh, float albedo, const formats::LightRig& rig, double x,
                       double z, int batches) {
  const Surface surface = surfaceOf(mesh, albedo);
  const Scene scene = sceneOf(surface, rig);
  const Ground ground({{1, 1, 1}, 20}, mesh, transport::boundingSphere(mesh), Eigen::Matrix3d::Identity());
  const auto seen = ground.seen({x, 5, z}, -Vec3::UnitY(), scene.diffuseMaterial());
  return estimate(scene, {}, seen.value().point, Vec3::UnitY(), batches);
}

TEST(Ground, BesideABlackBallUnderAnEvenSkyLosesItsFormFactor) {
  for (const double x : {0.5, 1.0, 2.0}) {
    const BatchMeans found = radiosityAt(standingBall(), 0, uniformRig(), x, 0, 200);
    const double expected = 1 - std::pow(1 + x * x, -1.5);
    EXPECT_NEAR(found.luminance(), expected, 3 * std::sqrt(found.luminanceVariance()) + 1e-3) << x;
    EXPECT_LT(std::sqrt(found.luminanceVariance()), 0.01);
  }
}

TEST(Ground, BesideAWhiteBallUnderAnEvenSkyLosesNothing) {
  const BatchMeans found = radiosityAt(standingBall(), 1, uniformRig(), 0.7, 0.2, 200);
  EXPECT_NEAR(found.luminance(), 1, 3 * std::sqrt(found.luminanceVariance()) + 1e-3);
}

// A disk of half angle a overhead gives sin² a; behind the ball, nothing.
TEST(Ground, IsLitByADiskThatTheBallHidesOrNot) {
  const double a = 10 * std::numbers::pi / 180;
  const formats::LightRig overhead = diskRig(10, 1);
  const BatchMeans open = radiosityAt(standingBall(), 0, overhead, 3, 0, 100);
  EXPECT_NEAR(open.luminance(), std::sin(a) * std::sin(a), 3 * std::sqrt(open.luminanceVariance()) + 1e-4);
  const BatchMeans hidden = radiosityAt(standingBall(), 0, overhead, 0.3, 0, 20);
  EXPECT_EQ(hidden.luminance(), 0);
}

// Albedo 0.5, light of order 5 and its picture: what differs is SH truncation of what is behind the ball, and the grid.
TEST(Ground, IsWhatNeighborhoodTransferSaysUnderSmoothLight) {
  const TriangleMesh ball = standingBall();
  constexpr int kOrder = 6;
  const formats::Neighborhood made =
      groundOf(ball, unshadowedLight(ball, kOrder, {0.5F, 0.5F, 0.5F}), 40, 2, 2048);
  formats::LightRig rig = diskRig(50, 2, {0.5F, 1, 0.3F});
  rig.distant.emplace_back(formats::DiskLight{{0, 1, 0}, 180, {0.3F, 0.3F, 0.3F}});
  transport::GroundShading ground(made);
  ground.setLight(transport::lightingFromRig(rig, kOrder, "made").distant, {});
  double squares = 0, differences = 0;
  for (const double x : {-2.5, -1.5, -0.8, 0.8, 1.6})
    for (const double z : {-1.2, 0.0, 1.1}) {
      const double truth = radiosityAt(ball, 0.5F, rig, x, z, 60).luminance();
      const double found = ground.radiosityAt(x, z)[1];
      squares += truth * truth, differences += (truth - found) * (truth - found);
    }
  std::printf("relative RMSE %.4f\n", std::sqrt(differences / squares));
  EXPECT_LT(std::sqrt(differences / squares), 0.03);
}

TEST(Ground, IsSeenFromAboveUntilItHasFadedOut) {
  const TriangleMesh ball = standingBall(2);
  const Ground ground({{0.5F, 0.5F, 0.5F}, 1}, ball, transport::boundingSphere(ball),
                      Eigen::Matrix3d::Identity());
  EXPECT_TRUE(ground.seen({0, 1, 0}, -Vec3::UnitY(), 0));
  EXPECT_EQ(ground.seen({0, 1, 0}, -Vec3::UnitY(), 0)->opacity, 1);
  EXPECT_FALSE(ground.seen({0, -1, 0}, Vec3::UnitY(), 0));
  EXPECT_FALSE(ground.seen({0, -1, 0}, -Vec3::UnitY(), 0));
  EXPECT_FALSE(ground.seen({0, 1, 0}, Vec3::UnitX(), 0));
  EXPECT_LT(ground.seen({1.8, 1, 0}, -Vec3::UnitY(), 0)->opacity, 0.5);
  EXPECT_FALSE(ground.seen({2.1, 1, 0}, -Vec3::UnitY(), 0));
}

TEST(Ground, AtVerticesIsRefusedByName) {
  Options options;
  options.at = At::kVertices;
  options.ground = GroundOptions();
  try {
    makeReference(surfaceOf(standingBall(2), 0.5F), uniformRig(), options, {}, stage::ProgressStyle::kNone);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("/ground"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace bakelight::reference
