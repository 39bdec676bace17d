#include <gtest/gtest.h>

#include <numbers>

#include "tests/unit/reference/scenes.h"
#include "transport/diffusion.h"

namespace bakelight::tests {
namespace {

using namespace reference;
using formats::PunctualLight;

constexpr double kPi = std::numbers::pi;

formats::LightRig rigOf(const PunctualLight& light) {
  formats::LightRig rig;
  rig.object_units = false;
  rig.punctual = {light};
  return rig;
}

PunctualLight lightAt(const Float3& position, PunctualLight::Type type = PunctualLight::Type::kPoint) {
  PunctualLight light;
  light.type = type;
  light.position = position;
  light.intensity = {30, 20, 10};
  light.direction = {0, -1, 0};
  return light;
}

ShadingPoint floorPoint(double x, double z) {
  return {{x, 1e-4, z}, Vec3::UnitY(), Rgb::Constant(0.5), 0, {x, 0, z}, 0};
}

Rgb seenAt(const Scene& scene, double x, double z, const PathOptions& options = {}) {
  return estimate(scene, options, floorPoint(x, z), Vec3::UnitY(), 1).mean();
}

// Albedo ÷ π · I cos θ ÷ d², without any noise, by both integrators.
TEST(PunctualLights, PlaneUnderAPointLight) {
  const Scene scene = sceneOf(surfaceOf(floorSquare(10), 0.5F), rigOf(lightAt({1, 3, 0})));
  for (const Integrator integrator : {Integrator::kMis, Integrator::kUniform})
    for (const double x : {-2.0, 1.0, 4.0}) {
      const double squared = 9 + (x - 1) * (x - 1), cosine = 3 / std::sqrt(squared);
      const Rgb seen = seenAt(scene, x, 0, {.integrator = integrator});
      EXPECT_NEAR(seen[0] / (0.5 / kPi * 30 * cosine / squared), 1, 1e-3) << x;
      EXPECT_NEAR(seen[2] / seen[0], 1.0 / 3, 1e-6);
    }
  EXPECT_EQ(seenAt(sceneOf(surfaceOf(floorSquare(10), 0.5F), rigOf(lightAt({1, -3, 0}))), 0, 0)[0], 0)
      << "from below";
}

TEST(PunctualLights, AConeEndsWhereItsAngleSays) {
  PunctualLight spot = lightAt({0, 2, 0}, PunctualLight::Type::kSpot);
  spot.inner_half_angle_deg = 20;
  spot.outer_half_angle_deg = 30;
  const Scene scene = sceneOf(surfaceOf(floorSquare(10), 0.5F), rigOf(spot));
  const auto radius = [](double angle_deg) { return 2 * std::tan(angle_deg * kPi / 180); };
  const auto full = [](double r) { return 0.5 / kPi * 30 * 2 / std::pow(4 + r * r, 1.5); };
  EXPECT_NEAR(seenAt(scene, radius(19), 0)[0] / full(radius(19)), 1, 1e-3);
  const double share = (std::cos(25 * kPi / 180) - std::cos(30 * kPi / 180)) /
                       (std::cos(20 * kPi / 180) - std::cos(30 * kPi / 180));
  EXPECT_NEAR(seenAt(scene, 0, radius(25))[0] / full(radius(25)), share * share, 1e-3);
  EXPECT_EQ(seenAt(scene, 0, -radius(30.5))[0], 0);
}

TEST(PunctualLights, ASlideOfSquaresFallsInSquares) {
  auto image = std::make_shared<formats::Image>(4, 4, std::vector<std::string>{"R", "G", "B"});
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x)
      for (int c = 0; c < 3; ++c) image->texel(x, y)[c] = (x + y) % 2 == 0 ? 1 : 0;
  PunctualLight slide = lightAt({0, 2, 0}, PunctualLight::Type::kSlide);
  slide.up = {0, 0, -1};
  slide.field_of_view_deg = 90;  // 4 × 4 on the floor, squares of 1
  slide.image = image;
  const Scene scene = sceneOf(surfaceOf(floorSquare(10), 0.5F), rigOf(slide));
  for (int row = -1; row <= 4; ++row)
    for (int column = -1; column <= 4; ++column)
      for (const double within : {0.02, 0.98}) {
        const double x = column - 2 + within, z = row - 2 + within;
        const bool lit = row >= 0 && row < 4 && column >= 0 && column < 4 && (row + column) % 2 == 0;
        const double expected = lit ? 0.5 / kPi * 30 * 2 / std::pow(4 + x * x + z * z, 1.5) : 0;
        EXPECT_NEAR(seenAt(scene, x, z)[0], expected, 1e-3 * expected) << row << ' ' << column;
      }
}

// A square plate half way up throws a shadow of twice its size; without shadows there is none.
TEST(PunctualLights, APlateThrowsItsShadow) {
  TriangleMesh mesh = floorSquare(10);
  for (const Float3& corner : floorSquare(0.5F).positions) {
    mesh.positions.push_back({corner[0], 1, corner[2]});
    mesh.normals.push_back({0, 1, 0});
  }
  mesh.triangles.push_back({4, 5, 6});
  mesh.triangles.push_back({4, 6, 7});
  const Scene scene = sceneOf(surfaceOf(mesh, 0.5F), rigOf(lightAt({0, 2, 0})));
  const PathOptions shadowed{.transport = Transport::kShadowed},
      unshadowed{.transport = Transport::kUnshadowed};
  for (const double x : {0.0, 0.98, -0.98}) {
    EXPECT_EQ(seenAt(scene, x, 0.3, shadowed)[0], 0) << x;
    EXPECT_GT(seenAt(scene, x, 0.3, unshadowed)[0], 0) << x;
  }
  EXPECT_GT(seenAt(scene, 1.02, 0.3, shadowed)[0], 0);
  EXPECT_GT(seenAt(scene, 0.3, -1.02, shadowed)[0], 0);
}

// Far above a plane of a medium a point light is even light.
TEST(PunctualLights, EnterMediaByTheirCosine) {
  const formats::Medium medium{{2, 2, 2}, {0.5F, 0.5F, 0.5F}, 1.3, 1, {}};
  Surface surface = surfaceOf(floorSquare(60), 1);
  surface.material.media = {medium};
  PunctualLight light = lightAt({0, 3000, 3000});
  light.intensity = {9e7F, 9e7F, 9e7F};  // irradiance 5
  const Scene scene = sceneOf(surface, rigOf(light));
  transport::Hit middle;
  middle.valid = true;
  middle.v = 0.5F;
  const auto means =
      estimate(scene, {.transport = Transport::kShadowed}, scene.pointAt(middle), Vec3::UnitY(), 200);
  const double cosine = std::sqrt(0.5);
  const transport::DiffuseReflectance reflectance(medium.model, {2, 0.5, 1.3});
  const double expected = 5 * cosine * transport::schlickTransmittance(cosine, 1.3) * reflectance.total() *
                          transport::schlickTransmittance(1, 1.3) / kPi;
  EXPECT_NEAR(means.mean()[0] / expected, 1, 0.03);
}

}  // namespace
}  // namespace bakelight::tests
