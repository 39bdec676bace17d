#include "transport/near_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <Eigen/Geometry>
#include <numbers>

#include "tests/e2e/made_packs.h"
#include "transport/sh.h"

namespace bakelight::transport {
namespace {

constexpr int kOrder = 4;

Lighting lightingOf(const formats::Emitter& emitter) {
  Lighting lighting;
  lighting.near.emitters.push_back(emitter);
  lighting.near.object_units = false;
  return lighting;
}

ShLight nearLightOf(const formats::Pack& pack, const Lighting& lighting,
                    const Eigen::Matrix3d& turn = Eigen::Matrix3d::Identity()) {
  return nearLight(pack.mesh, makePackShading(pack)->needs(), lighting, 0, turn);
}

TEST(NearLight, AnEmitterAllAroundIsAUniformLight) {
  formats::Emitter around;
  around.shape = formats::Emitter::Shape::kSphere;
  around.radius = 3;
  around.radiance = {1, 2, 3};
  const ShLight light = nearLightOf(tests::spherePack(kOrder, 8), lightingOf(around));
  const ShLight expected = uniformLight(kOrder, around.radiance);
  ASSERT_EQ(light.size(), expected.size());
  for (std::size_t i = 0; i < light.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(light[i][c], expected[i][c], 1e-4) << i;
}

// A turned object sees the light turned the other way; the body's centre is not the origin.
TEST(NearLight, IsInTheTurnedObjectsFrame) {
  const formats::Pack pack = tests::wavyPack(kOrder, 12);
  formats::Emitter lamp;
  lamp.shape = formats::Emitter::Shape::kSphere;
  lamp.radius = 0.7;
  lamp.position = {1.5F, -1, 6.5F};
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.8, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  Lighting lighting = lightingOf(lamp);
  lighting.cube_resolution = 192;
  const ShLight still = nearLightOf(pack, lighting);
  const ShLight turned = nearLightOf(pack, lighting, turn);
  const ShLight expected = ShRotation(kOrder, turn.transpose()).apply(still);
  double difference = 0;
  for (std::size_t i = 0; i < turned.size(); ++i) {
    EXPECT_NEAR(turned[i][1], expected[i][1], 0.01 * still[0][1]) << i;
    difference = std::max(difference, std::abs(static_cast<double>(turned[i][1]) - still[i][1]));
  }
  EXPECT_GT(difference, 0.3 * still[0][1]) << "the turn shows";
}

TEST(NearLight, StandsAtTheVirtualSpheresCenterWherePacksHaveNearVectors) {
  formats::Pack pack = tests::spherePack(kOrder, 8);
  formats::Emitter lamp;
  lamp.shape = formats::Emitter::Shape::kSphere;
  lamp.radius = 0.5;
  lamp.position = {0, 0, 4};
  const ShLight from_middle = nearLightOf(pack, lightingOf(lamp));
  tests::addNearTransfer(pack, 2);
  pack.sh().near_field->center = {0, 0, 2};
  const ShLight from_sphere = nearLightOf(pack, lightingOf(lamp));
  // Solid angles of a ball of radius 0.5 at distances 4 and 2.
  const auto solid_angle = [](double distance) {
    return 2 * std::numbers::pi * (1 - std::sqrt(1 - 0.25 / (distance * distance)));
  };
  const double y0 = 0.5 / std::sqrt(std::numbers::pi);
  EXPECT_NEAR(from_middle[0][0], y0 * solid_angle(4), 0.05 * y0 * solid_angle(4));
  EXPECT_NEAR(from_sphere[0][0], y0 * solid_angle(2), 0.03 * y0 * solid_angle(2));
}

TEST(NearLight, IsEmptyWithoutEmitters) {
  EXPECT_TRUE(nearLightOf(tests::spherePack(2, 4), Lighting()).empty());
}

}  // namespace
}  // namespace bakelight::transport
