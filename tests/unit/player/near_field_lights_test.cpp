#include "tools/player/lights/near_field_lights.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "formats/error.h"
#include "tools/player/gl/gl_context.h"

namespace bakelight::player {
namespace {

using formats::Emitter;
using transport::Float3;
using transport::Vec3;

constexpr double kPi = std::numbers::pi;
const transport::BoundingSphere kObject{{0, 0, 0}, 1};

Emitter sphereEmitter(const Float3& position, double radius, const Float3& radiance = {1, 1, 1}) {
  Emitter emitter;
  emitter.shape = Emitter::Shape::kSphere;
  emitter.position = position;
  emitter.radius = radius;
  emitter.radiance = radiance;
  return emitter;
}

Emitter quadEmitter(const Float3& position, const Float3& normal, const Float3& radiance) {
  Emitter emitter;
  emitter.position = position;
  emitter.normal = normal;
  emitter.width = 0.8;
  emitter.height = 1.7;
  emitter.radiance = radiance;
  return emitter;
}

formats::LightRig rigOf(std::vector<Emitter> emitters) {
  formats::LightRig rig;
  rig.emitters = std::move(emitters);
  return rig;
}

// On all six faces, before and behind each other, one of them moving.
formats::LightRig crowd() {
  formats::LightRig rig = rigOf({quadEmitter({1.5f, 0.2f, 0.1f}, {-1, 0.3f, 0}, {5, 1, 0}),
                                 quadEmitter({2.5f, 0.2f, 0.4f}, {-1, 0, 0}, {0, 3, 1}),
                                 sphereEmitter({-1.1f, 0.4f, 0.3f}, 0.5, {1, 2, 3}),
                                 sphereEmitter({0.3f, 1.2f, 0.2f}, 0.4, {7, 2, 0.5f}),
                                 sphereEmitter({0.1f, -1.3f, -0.3f}, 0.6, {0.1f, 0.2f, 9}),
                                 quadEmitter({0.2f, 0.1f, -1.2f}, {0, 0.2f, 1}, {2, 2, 2})});
  rig.emitters[2].motion.kind = formats::Motion::Kind::kOrbit;
  rig.emitters[2].motion.period_s = 4;
  return rig;
}

double distance(const transport::ShLight& a, const transport::ShLight& b) {
  EXPECT_EQ(a.size(), b.size());
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) sum += std::pow(a[i][c] - b[i][c], 2);
  return std::sqrt(sum);
}

double norm(const transport::ShLight& light) {
  return distance(light, transport::ShLight(light.size(), Float3{0, 0, 0}));
}

// Order 5 light of one emitter at `resolution` texels.
transport::ShLight lightOf(const Emitter& emitter, int resolution = 64) {
  NearFieldLights lights(rigOf({emitter}), kObject, Vec3::Zero(), 5, resolution);
  lights.project(Eigen::Matrix3d::Identity());
  return lights.readLight();
}

class NearFieldLightsTest : public testing::Test {
 protected:
  HeadlessContext context_;
};

TEST_F(NearFieldLightsTest, CubeIsThatOfTheRayTracer) {
  const Vec3 center(0.05, -0.1, 0.02);
  NearFieldLights lights(crowd(), kObject, center, 4, 96);
  for (const double time_s : {0.0, 1.3}) {
    lights.place(time_s);
    lights.project(Eigen::Matrix3d::Identity());
    const auto drawn = lights.readCube();
    const auto traced =
        transport::renderEmitterCube(transport::emitterMesh(crowd(), kObject, time_s), center, 96);
    ASSERT_EQ(drawn.values.size(), traced.values.size());
    std::size_t different = 0, lit = 0;
    for (std::size_t i = 0; i < drawn.values.size(); ++i) {
      if (std::abs(drawn.values[i] - traced.values[i]) > 1e-5f * traced.values[i]) ++different;
      if (traced.values[i] != 0) ++lit;
    }
    EXPECT_GT(lit, drawn.values.size() / 8);
    // Rounding decides a texel at an outline here and there.
    EXPECT_LT(different, drawn.values.size() / 2000) << time_s;
  }
}

TEST_F(NearFieldLightsTest, ProjectionIsThatOfTheCpuForEachOrder) {
  for (const int order : {1, 2, 5, 10}) {
    NearFieldLights lights(crowd(), kObject, Vec3::Zero(), order, 48);
    lights.project(Eigen::Matrix3d::Identity());
    const auto expected = transport::projectCubeMap(lights.readCube(), order, "cube");
    EXPECT_LT(distance(lights.readLight(), expected), 1e-5 * norm(expected)) << order;
  }
}

TEST_F(NearFieldLightsTest, SameBitsEachTime) {
  NearFieldLights lights(crowd(), kObject, Vec3::Zero(), 5, 64);
  lights.project(Eigen::Matrix3d::Identity());
  const auto first = lights.readLight();
  lights.place(1);
  lights.project(Eigen::Matrix3d::Identity());
  EXPECT_GT(distance(lights.readLight(), first), 0.01 * norm(first)) << "nothing moved";
  lights.place(0);
  lights.project(Eigen::Matrix3d::Identity());
  EXPECT_EQ(lights.readLight(), first);
}

// Solid angles that sum to 4π, and a basis that is orthogonal to a constant: closed form of a uniform sky.
TEST_F(NearFieldLightsTest, LightAllAroundIsUniform) {
  for (const int resolution : {16, 64}) {
    const auto light = lightOf(sphereEmitter({0.1f, 0, 0}, 0.7, {2, 2, 2}), resolution);
    EXPECT_NEAR(light[0][0], 2 * std::sqrt(4 * kPi), 1e-5);
    // Texels near the corners of a face see the basis at their centre only: an error that falls with their
    // size.
    for (std::size_t i = 1; i < light.size(); ++i)
      EXPECT_NEAR(light[i][0], 0, 4.0 / (resolution * resolution));
  }
}

TEST_F(NearFieldLightsTest, SphereIsADiskLight) {
  for (const double distance_to_light : {0.5, 1.0, 2.0}) {
    const double radius = 0.3, half_angle = std::asin(radius / distance_to_light);
    const auto light = lightOf(sphereEmitter({0, static_cast<float>(distance_to_light), 0}, radius), 256);
    const auto expected = transport::diskLight(5, Vec3::UnitY(), half_angle, {1, 1, 1});
    EXPECT_LT(distance(light, expected), 0.01 * norm(expected)) << distance_to_light;
  }
}

TEST_F(NearFieldLightsTest, TurningTheObjectTurnsTheLightBack) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.8, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  NearFieldLights lights(crowd(), kObject, Vec3::Zero(), 5, 192);
  lights.project(Eigen::Matrix3d::Identity());
  const auto expected = transport::ShRotation(5, turn.transpose()).apply(lights.readLight());
  lights.project(turn);
  EXPECT_LT(distance(lights.readLight(), expected), 0.01 * norm(expected));
}

// From afar to the wall, through the body and over the centre: never less than before, never more than light
// from all sides.
TEST_F(NearFieldLightsTest, ApproachingLightIsFiniteAndMonotone) {
  double before = 0;
  for (const double d :
       {100.0, 10.0, 3.0, 2.0, 1.3, 1.0001, 1.0, 0.9999, 0.7, 0.5, 0.31, 0.3, 0.29, 0.1, 1e-6, 0.0}) {
    const auto light =
        lightOf(sphereEmitter({static_cast<float>(0.6 * d), 0, static_cast<float>(0.8 * d)}, 0.3));
    for (const auto& coefficient : light)
      for (const float value : coefficient) ASSERT_TRUE(std::isfinite(value)) << d;
    EXPECT_GE(light[0][0], before - 1e-6) << d;
    before = light[0][0];
  }
  EXPECT_NEAR(before, std::sqrt(4 * kPi), 1e-5);
}

TEST_F(NearFieldLightsTest, QuadThroughTheCenterIsFinite) {
  const auto light = lightOf(quadEmitter({0, 0, 0}, {0.3f, 1, 0.2f}, {1, 1, 1}));
  for (const auto& coefficient : light)
    for (const float value : coefficient) {
      EXPECT_TRUE(std::isfinite(value));
      EXPECT_LE(std::abs(value), std::sqrt(4 * kPi));
    }
}

TEST_F(NearFieldLightsTest, TooLargeAndNotFiniteAreErrorsThatSaySo) {
  EXPECT_THROW(NearFieldLights(crowd(), kObject, Vec3::Zero(), 10, 16384), Error);
  auto rig = crowd();
  rig.emitters[1].radiance[2] = std::numeric_limits<float>::quiet_NaN();
  try {
    const NearFieldLights lights(rig, kObject, Vec3::Zero(), 3, 16);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    EXPECT_THAT(error.what(), testing::HasSubstr("not finite"));
  }
}

}  // namespace
}  // namespace bakelight::player
