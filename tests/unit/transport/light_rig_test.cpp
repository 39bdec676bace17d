#include "transport/light_rig.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

#include "formats/error.h"
#include "transport/cube_map.h"
#include "transport/evaluator.h"
#include "transport/windowing.h"

namespace bakelight::transport {
namespace {

constexpr double kPi = std::numbers::pi;
using Radiance = std::function<Float3(const Vec3&)>;

formats::Image latLong(int height, const Radiance& radiance) {
  formats::Image image(2 * height, height, {"R", "G", "B"});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Float3 value = radiance(directionOfLatLong((x + 0.5) / image.width, (y + 0.5) / height));
      std::copy(value.begin(), value.end(), image.texel(x, y));
    }
  return image;
}

formats::Image cubeMap(int resolution, bool side_by_side, const Radiance& radiance) {
  formats::Image strip(side_by_side ? 6 * resolution : resolution, side_by_side ? resolution : 6 * resolution,
                       {"R", "G", "B"});
  const CubeStrip layout = cubeStrip(strip, "test");
  for (int face = 0; face < kCubeFaces; ++face)
    for (int y = 0; y < resolution; ++y)
      for (int x = 0; x < resolution; ++x) {
        const Float3 value =
            radiance(directionOfCubeFace(face, (x + 0.5) / resolution, (y + 0.5) / resolution));
        const auto [column, row] = layout.texelAt(face, x, y);
        std::copy(value.begin(), value.end(), strip.texel(column, row));
      }
  return strip;
}

Float3 smooth(const Vec3& d) {
  return {static_cast<float>(1 + d.x() + d.y() * d.z()), static_cast<float>(std::exp(d.y())),
          static_cast<float>(2 + d.z() * d.z() * d.x())};
}

void expectNear(const ShLight& light, const ShLight& expected, double tolerance) {
  ASSERT_EQ(light.size(), expected.size());
  for (std::size_t i = 0; i < light.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(light[i][c], expected[i][c], tolerance) << "coefficient " << i << ", colour " << c;
}

formats::LightRig rigOf(std::vector<formats::DistantLight> lights) {
  formats::LightRig rig;
  rig.distant = std::move(lights);
  return rig;
}

TEST(CubeMapLight, ConstantCubeIsTheUniformLight) {
  for (const int resolution : {1, 7, 64}) {
    const auto strip = cubeMap(resolution, true, [](const Vec3&) { return Float3{1, 2, 3}; });
    const ShLight light = projectCubeMap(strip, 5, "test");
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(light[0][c], std::sqrt(4 * kPi) * static_cast<double>(c + 1), 3e-6);
    for (int i = 1; i < 16; ++i)  // bands 1 to 3 by the cube's symmetry
      EXPECT_NEAR(light[i][2], 0, 1e-5);
    // Band 4 has the cube's symmetry itself: the centre rule's error, O(1/resolution²).
    for (int i = 16; i < 25; ++i) EXPECT_NEAR(light[i][0], 0, 10.0 / (resolution * resolution));
  }
}

TEST(CubeMapLight, BothLayoutsAndTheLatLongAgree) {
  const ShLight beside = projectCubeMap(cubeMap(128, true, smooth), 6, "test");
  EXPECT_EQ(projectCubeMap(cubeMap(128, false, smooth), 6, "test"), beside);
  expectNear(projectLatLong(latLong(256, smooth), 6, "test"), beside, 1e-3);
}

TEST(CubeMapLight, LookUpFindsWhatWasPutIn) {
  const auto strip = cubeMap(64, false, smooth);
  for (const Vec3& d : {Vec3(1, 0.2, 0.3), Vec3(-0.2, -1, 0.4), Vec3(0.5, 0.1, -2)}) {
    const Float3 found = lookUpCubeMap(strip, d.normalized()), expected = smooth(d.normalized());
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 2e-3);
  }
}

TEST(CubeMapLight, RefusesOtherShapes) {
  EXPECT_THROW(projectCubeMap(formats::Image(8, 4, {"R", "G", "B"}), 3, "wide.exr"), Error);
}

TEST(LightRig, SumsItsLights) {
  const formats::DiskLight disk = {.direction = {0, 2, 1}, .half_angle_deg = 20, .radiance = {3, 2, 1}};
  const formats::PolygonLight polygon = {.vertices = {{2, 0, 0}, {2, 1, 0}, {2, 1, 1}},
                                         .radiance = {1, 5, 1}};
  const formats::DirectionalLight directional = {.direction = {0, 0, -3}, .irradiance = {0, 1, 2}};
  const RigLight all = distantLight(rigOf({disk, polygon, directional}), 5);
  ShLight expected = sum(projectLight(disk, 5), projectLight(polygon, 5));
  expected = sum(expected, projectLight(directional, 5));
  EXPECT_EQ(all.light, expected);
  EXPECT_EQ(all.moved_energy, 0);
  EXPECT_EQ(all.window, 0);
}

// A surface facing a directional light gets its irradiance, up to the cosine's bands beyond the order:
// Σ A_l (2l+1)/4π over odd and even l tends to 1.
TEST(LightRig, DirectionalLightGivesItsIrradiance) {
  const int order = kMaxOrder;
  const Vec3 towards = Vec3(1, 2, -2) / 3;
  const ShLight light = directionalLight(order, towards, {2, 4, 8});
  const auto factors = clampedCosineFactors(order);
  const auto basis = evaluateSh(order, towards);
  double irradiance = 0;
  for (int l = 0; l < order; ++l)
    for (int i = l * l; i < (l + 1) * (l + 1); ++i) irradiance += factors[l] * basis[i] * light[i][1];
  EXPECT_NEAR(irradiance, 4, 0.02 * 4);
  EXPECT_NEAR(light[0][2] * std::sqrt(4 * kPi), 8, 1e-5);
}

TEST(LightRig, TurningTheRigRotatesTheLight) {
  const double yaw_deg = 50;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(yaw_deg * kPi / 180, Vec3::UnitY()).toRotationMatrix();
  formats::EnvironmentLight environment;
  environment.image = latLong(64, smooth);
  formats::DiskLight disk = {.direction = {1, 1, 0.2F}, .half_angle_deg = 15, .radiance = {2, 2, 2}};
  formats::PolygonLight polygon = {.vertices = {{2, 0, 0}, {2, 1, 0}, {2, 1, 1}}, .radiance = {1, 5, 1}};
  formats::SkyLight sky;
  const ShLight before = distantLight(rigOf({environment, disk, polygon, sky}), 7).light;

  environment.yaw_deg = yaw_deg;
  disk.direction = float3(turn * vec3(disk.direction));
  for (Float3& vertex : polygon.vertices) vertex = float3(turn * vec3(vertex));
  sky.sun_azimuth_deg = yaw_deg;
  const ShLight after = distantLight(rigOf({environment, disk, polygon, sky}), 7).light;
  expectNear(after, ShRotation(7, turn).apply(before), 2e-5 * before[0][1]);
}

// A body turned by R under a light shines as the unturned body does under the light turned by R⁻¹.
TEST(LightRig, TurningTheBodyIsTurningTheLightBack) {
  const int order = 6;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.3, Vec3(1, -1, 2).normalized()).toRotationMatrix();
  const ShLight light = distantLight(rigOf({formats::SkyLight{}, formats::DiskLight{}}), order).light;
  const auto convexTransfer = [&](const Eigen::Matrix3d& world_from_body) {
    std::vector<float> vectors;
    const auto factors = clampedCosineFactors(order);
    for (const Vec3& normal : {Vec3(1, 0, 0), Vec3(0, 0.6, 0.8), Vec3(-2, 1, -2).normalized()}) {
      const auto basis = evaluateSh(order, world_from_body * normal);
      for (int l = 0; l < order; ++l)
        for (int i = l * l; i < (l + 1) * (l + 1); ++i)
          vectors.push_back(static_cast<float>(factors[l] / kPi * basis[i]));
    }
    return vectors;
  };
  const auto turned_body = evaluateDiffuse(convexTransfer(turn), order, light);
  const ShLight turned_light = ShRotation(order, turn.transpose()).apply(light);
  const auto turned_back = evaluateDiffuse(convexTransfer(Eigen::Matrix3d::Identity()), order, turned_light);
  for (std::size_t v = 0; v < turned_body.size(); ++v)
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(turned_body[v][c], turned_back[v][c], 1e-5 * light[0][1]);
}

// The yaw turns the picture the same way as the light: both equal a picture made for the turned directions.
TEST(LightRig, YawTurnsImageAndLightAlike) {
  formats::EnvironmentLight environment;
  environment.image = latLong(256, smooth);
  environment.yaw_deg = 90;
  const Radiance turned = [](const Vec3& d) { return smooth(Vec3(-d.z(), d.y(), d.x())); };
  const formats::Image expected = latLong(256, turned);
  const RigLight light = distantLight(rigOf({environment}), 5);
  expectNear(light.light, projectLatLong(expected, 5, "test"), 1e-4);
  ASSERT_EQ(light.backdrop.values.size(), expected.values.size());
  for (std::size_t i = 0; i < expected.values.size(); ++i)
    ASSERT_NEAR(light.backdrop.values[i], expected.values[i], 1e-3);
}

TEST(LightRig, BackdropOfAnUnturnedEnvironmentIsTheEnvironment) {
  formats::EnvironmentLight environment;
  environment.image = latLong(280, smooth);
  environment.intensity = 2;
  const formats::Image backdrop = distantLight(rigOf({environment}), 2).backdrop;
  ASSERT_EQ(backdrop.width, 560);
  for (std::size_t i = 0; i < backdrop.values.size(); ++i)
    ASSERT_NEAR(backdrop.values[i], 2 * environment.image.values[i], 2e-4);
}

TEST(LightRig, BackdropHasTheSizeOfTheLargestEnvironmentWithinBounds) {
  const auto widthWith = [](int height) {
    formats::EnvironmentLight environment;
    environment.image = formats::Image(2 * height, height, {"R", "G", "B"});
    return distantLight(rigOf({environment}), 1).backdrop.width;
  };
  EXPECT_EQ(distantLight(rigOf({}), 1).backdrop.width, 512);
  EXPECT_EQ(widthWith(16), 512);
  EXPECT_EQ(widthWith(300), 600);
  EXPECT_EQ(widthWith(1500), 2048);
}

// However small a light is, the picture carries its power.
TEST(LightRig, BackdropKeepsThePowerOfEachLight) {
  const std::vector<formats::DistantLight> lights = {
      formats::DiskLight{.direction = {1, 2, 3}, .half_angle_deg = 1e-3, .radiance = {1e6F, 1, 2}},
      formats::DiskLight{.direction = {0, 1, 0}, .half_angle_deg = 0.4, .radiance = {1, 1, 2}},
      formats::DiskLight{.direction = {-1, 0.1F, 0}, .half_angle_deg = 1.1, .radiance = {1, 1, 2}},
      formats::DiskLight{.direction = {0, 0, -1}, .half_angle_deg = 60, .radiance = {1, 1, 2}},
      formats::DiskLight{.direction = {0, 0, -1}, .half_angle_deg = 180, .radiance = {1, 1, 2}},
      formats::DirectionalLight{.direction = {1, -1, 1}, .irradiance = {1, 2, 3}},
      formats::PolygonLight{.vertices = {{5, 1, 0}, {5, 2, 0}, {5, 2, 3}, {5, 1, 3}}, .radiance = {1, 1, 2}},
      formats::PolygonLight{.vertices = {{50, 1, 0}, {50, 1.1F, 0}, {50, 1.1F, 0.1F}}, .radiance = {1, 1, 2}},
  };
  for (const auto& light : lights) {
    const RigLight rig = distantLight(rigOf({light}), 3);
    const ShLight drawn = projectLatLong(rig.backdrop, 3, "backdrop");
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(drawn[0][c], rig.light[0][c], 1e-5 * rig.light[0][c]);
    // A texel is 0.7°: so far may the direction of a point light be off, and the higher bands with it.
    for (std::size_t i = 1; i < drawn.size(); ++i)
      EXPECT_NEAR(drawn[i][0], rig.light[i][0], 0.03 * rig.light[0][0]) << light.index() << ", " << i;
  }
}

TEST(LightRig, WindowIsThatOfTheRig) {
  formats::LightRig rig = rigOf({formats::DirectionalLight{}});
  const ShLight unwindowed = distantLight(rig, 5).light;
  rig.windowing = 0.003;
  EXPECT_EQ(distantLight(rig, 5).light, window(unwindowed, 0.003).light);
  EXPECT_EQ(distantLight(rig, 5).window, 0.003);
  rig.windowing = -1;
  const RigLight automatic = distantLight(rig, 5);
  EXPECT_EQ(automatic.light, windowUntilPositive(unwindowed).light);
  EXPECT_GT(automatic.window, 0);
  EXPECT_GT(automatic.moved_energy, 0.05);
}

TEST(LightRig, RefusesLightThatIsNotFinite) {
  EXPECT_THROW(distantLight(rigOf({formats::DiskLight{.radiance = {3e38F, 1, 1}},
                                   formats::DiskLight{.half_angle_deg = 180, .radiance = {3e38F, 1, 1}}}),
                            3),
               Error);
}

TEST(LightRig, ErrorsSayWhichLight) {
  const formats::PolygonLight half_the_sky = {.vertices = {{1, 0, 0}, {-0.5F, 0, 0.9F}, {-0.5F, 0, -0.9F}}};
  formats::EnvironmentLight square;
  square.path = "square.exr";
  square.image = formats::Image(9, 9, {"R", "G", "B"});
  for (const formats::DistantLight& light :
       {formats::DistantLight(half_the_sky), formats::DistantLight(square)})
    try {
      distantLight(rigOf({formats::DiskLight{}, light}), 3);
      ADD_FAILURE() << "no error";
    } catch (const Error& error) {
      EXPECT_EQ(error.place().pointer, "/lights/1");
    }
}

TEST(LightRig, SameBytesWithAnyNumberOfThreads) {
  formats::EnvironmentLight environment;
  environment.image = cubeMap(33, true, smooth);
  formats::LightRig rig = rigOf({environment, formats::SkyLight{}, formats::DiskLight{}});
  rig.windowing = -1;
  const RigLight many = distantLight(rig, 6);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const RigLight alone = distantLight(rig, 6);
  EXPECT_EQ(alone.light, many.light);
  EXPECT_EQ(alone.backdrop.values, many.backdrop.values);
}

}  // namespace
}  // namespace bakelight::transport
