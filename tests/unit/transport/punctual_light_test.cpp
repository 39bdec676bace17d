#include "transport/punctual_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "transport/lighting.h"
#include "transport/near_light.h"

namespace bakelight::transport {
namespace {

using formats::PunctualLight;

constexpr double kDegree = std::numbers::pi / 180;
const BoundingSphere kUnitSphere = {Vec3::Zero(), 1};

PlacedPunctualLight placed(const PunctualLight& light, double time_s = 0) {
  formats::LightRig rig;
  rig.punctual = {light};
  return placedPunctualLights(rig, kUnitSphere, time_s).front();
}

TEST(PunctualLight, PointDimsWithTheSquareOfDistanceAndIsFiniteAtItself) {
  PunctualLight light;
  light.position = {1, 2, 3};
  light.intensity = {8, 4, 2};
  const PlacedPunctualLight point = placed(light);
  EXPECT_NEAR(point.irradianceFacing({1, 2, 5})[0], 2, 1e-12);
  EXPECT_NEAR(point.irradianceFacing({1, -2, 3})[1], 0.25, 1e-12);
  EXPECT_EQ(point.irradianceFacing({1, 2, 3})[2], 0);
}

// A rig in the object's units lights an object a hundred times larger, elsewhere, just the same.
TEST(PunctualLight, ObjectUnitsGoWithTheObject) {
  formats::LightRig rig;
  rig.punctual.resize(1);
  rig.punctual[0].position = {0, 2, 0};
  const BoundingSphere large = {{5, 6, 7}, 100};
  const auto lights = placedPunctualLights(rig, large, 0);
  EXPECT_TRUE(lights[0].position.isApprox(Vec3(5, 206, 7)));
  EXPECT_NEAR(lights[0].irradianceFacing({5, 6, 7})[0], 0.25, 1e-12);
  rig.object_units = false;
  EXPECT_TRUE(placedPunctualLights(rig, large, 0)[0].position.isApprox(Vec3(0, 2, 0)));
}

TEST(PunctualLight, SpotFadesBetweenItsAnglesAsInGltf) {
  for (const auto& [inner_deg, outer_deg] : {std::pair(10.0, 30.0), {0.0, 90.0}, {0.005, 0.01}}) {
    PunctualLight light;
    light.type = PunctualLight::Type::kSpot;
    light.direction = {0, -3, 0};
    light.inner_half_angle_deg = inner_deg;
    light.outer_half_angle_deg = outer_deg;
    const PlacedPunctualLight spot = placed(light);
    const auto at = [&](double angle_deg) {
      return spot.intensityTowards({std::sin(angle_deg * kDegree), -std::cos(angle_deg * kDegree), 0})[1];
    };
    EXPECT_EQ(at(0), 1);
    EXPECT_NEAR(at(0.999 * inner_deg), 1, 1e-9);
    const double middle_deg = (inner_deg + outer_deg) / 2;
    const double share = (std::cos(middle_deg * kDegree) - std::cos(outer_deg * kDegree)) /
                         (std::cos(inner_deg * kDegree) - std::cos(outer_deg * kDegree));
    EXPECT_NEAR(at(middle_deg), share * share, 1e-6) << outer_deg;
    EXPECT_NEAR(at(1.001 * outer_deg), 0, 1e-12) << outer_deg;
    EXPECT_EQ(at(180), 0);
  }
}

// Seen from behind the projector the picture is as in its file, and its edges are where the field of view ends.
TEST(PunctualLight, SlideShowsItsPictureUprightAndNothingBesideIt) {
  formats::Image image(4, 2, {"R", "G", "B"});
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x) image.texel(x, y)[0] = static_cast<float>(1 + x + 10 * y);
  PunctualLight light;
  light.type = PunctualLight::Type::kSlide;
  light.direction = {0, 0, -2};
  light.up = {0, 5, 3};
  light.field_of_view_deg = 90;
  light.image = std::make_shared<const formats::Image>(image);
  const PlacedPunctualLight slide = placed(light);
  const auto at = [&](double x, double y, double z = -1) {
    return slide.intensityTowards(Vec3(x, y, z).normalized())[0];
  };
  EXPECT_EQ(at(-1.5, 0.5), 1) << "upper left";
  EXPECT_EQ(at(1.5, 0.5), 4);
  EXPECT_EQ(at(-0.5, -0.5), 12);
  EXPECT_EQ(at(1.99, -0.99), 14);
  EXPECT_EQ(at(2.01, 0), 0);
  EXPECT_EQ(at(0, 1.01), 0);
  EXPECT_EQ(at(0.1, 0.1, 1), 0) << "behind";
}

TEST(PunctualLight, MotionTurnsWhereItShines) {
  PunctualLight light;
  light.type = PunctualLight::Type::kSpot;
  light.position = {0, 0, 2};
  light.direction = {0, 0, -1};
  light.motion = {.kind = formats::Motion::Kind::kOrbit, .period_s = 4};
  const PlacedPunctualLight moved = placed(light, 1);
  EXPECT_TRUE(moved.position.isApprox(Vec3(2, 0, 0), 1e-9));
  EXPECT_NEAR(moved.irradianceFacing(Vec3::Zero())[0], 0.25, 1e-9) << "still at the middle";
}

TEST(PunctualLight, AnObjectThatTurnsSeesThemTurnTheOtherWay) {
  formats::TriangleMesh mesh;
  mesh.positions = {{-1, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  formats::LightRig rig;
  rig.object_units = false;
  rig.punctual.resize(1);
  rig.punctual[0].position = {3, 0, 0};
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitY()).toRotationMatrix();
  const Vec3 center = boundingSphere(mesh).center;
  const Vec3 seen = punctualLightsOn(mesh, rig, 0, turn)[0].position;
  EXPECT_TRUE((turn * (seen - center) + center).isApprox(Vec3(3, 0, 0), 1e-6));
}

// Under nothing but a point light, the mean radiance is its irradiance ÷ 4π.
TEST(PunctualLight, ExposureGoesByItsIrradiance) {
  formats::TriangleMesh mesh;
  mesh.positions = {{-1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}};
  formats::LightRig rig;
  rig.punctual.resize(1);
  rig.punctual[0].position = {0, 0, 2};
  rig.punctual[0].intensity = {12, 12, 12};
  const Lighting lighting = lightingFor(rig, 1, "rig.json");
  EXPECT_EQ(lighting.distant[0][0], 0) << "no default light beside it";
  const ShLight light = exposureLight(mesh, {1}, lighting);
  EXPECT_NEAR(light[0][1] / std::sqrt(4 * std::numbers::pi), 3 / (4 * std::numbers::pi), 1e-6);
}

}  // namespace
}  // namespace bakelight::transport
