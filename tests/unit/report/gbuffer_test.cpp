#include "tools/report/gbuffer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/e2e/made_packs.h"
#include "transport/cpu_renderer.h"
#include "transport/ray_scene.h"

namespace bakelight::report {
namespace {

using transport::Float3, transport::Vec3;

constexpr transport::PictureGrid kGrid = {60, 40, 2};

std::vector<Float3> normalsAsRadiance(const formats::Pack& pack) {
  return {pack.mesh.normals.begin(), pack.mesh.normals.end()};
}

TEST(CameraFrom, StandsAndLooksWhereItIsTold) {
  transport::OrbitCamera expected;
  expected.target = {1, -2, 3};
  expected.distance = 5;
  for (const double yaw : {-170.0, -20.0, 0.0, 95.0})
    for (const double pitch : {-80.0, 0.0, 45.0}) {
      expected.yaw_deg = yaw;
      expected.pitch_deg = pitch;
      const transport::OrbitCamera camera = cameraFrom(expected.eye(), expected.target, 30);
      EXPECT_NEAR((camera.eye() - expected.eye()).norm(), 0, 1e-12);
      EXPECT_NEAR(camera.yaw_deg, yaw, 1e-9);
      EXPECT_NEAR(camera.pitch_deg, pitch, 1e-9);
      EXPECT_EQ(camera.field_of_view_deg, 30);
    }
  EXPECT_THROW(cameraFrom({1, 2, 3}, {1, 2, 3}, 30), std::invalid_argument);
}

const transport::RadianceAtHits kNoEmitters = transport::interpolated({}, {});

// The renderer that the previews use, with its own rays.
TEST(GBuffer, GivesThePictureOfTheCpuRenderer) {
  const formats::Pack pack = tests::wavyPack(2, 24);
  const auto camera = transport::frameSphere(transport::boundingSphere(pack.mesh), 30, 20, 35, 1.5);
  const std::vector<Float3> radiance = normalsAsRadiance(pack);
  const transport::RadianceAtHits shade = transport::interpolated(pack.mesh.triangles, radiance);
  const auto expected =
      transport::renderOnCpu(transport::RayScene(pack.mesh), shade, camera, kGrid, [](const Vec3&) {
        return formats::Float4{0, 0, 0, 0};
      });
  const GBuffer gbuffer = traceGBuffer(pack.mesh, {}, Eigen::Matrix3d::Identity(), camera, kGrid);
  const Picture picture = pictureOf(gbuffer, shade, kNoEmitters);
  ASSERT_EQ(picture.linear.values.size(), expected.linear.values.size());
  std::size_t covered = 0;
  for (std::size_t i = 0; i < picture.linear.values.size(); ++i) {
    EXPECT_NEAR(picture.linear.values[i], expected.linear.values[i], 1e-6);
    if (i % 4 != 3) continue;
    EXPECT_EQ(picture.covered[i / 4], picture.linear.values[i] == 1);
    covered += picture.covered[i / 4];
  }
  EXPECT_GT(covered, 400u);
}

// An object turned one way is seen as by a camera that orbits the other way.
TEST(GBuffer, TurnsTheObjectAboutTheCamerasTarget) {
  const formats::Pack pack = tests::wavyPack(2, 24);
  const auto bounds = transport::boundingSphere(pack.mesh);
  const auto camera = transport::frameSphere(bounds, 70, 0, 35, 1.5);
  const auto orbited = transport::frameSphere(bounds, 30, 0, 35, 1.5);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(40 * std::acos(-1.0) / 180, Vec3::UnitY()).toRotationMatrix();
  const std::vector<Float3> normals = normalsAsRadiance(pack);
  const transport::RadianceAtHits shade = transport::interpolated(pack.mesh.triangles, normals);
  const Picture turned = pictureOf(traceGBuffer(pack.mesh, {}, turn, camera, kGrid), shade, kNoEmitters);
  const Picture expected =
      pictureOf(traceGBuffer(pack.mesh, {}, Eigen::Matrix3d::Identity(), orbited, kGrid), shade, kNoEmitters);
  std::size_t different = 0;
  for (std::size_t i = 0; i < turned.linear.values.size(); ++i)
    different += std::abs(turned.linear.values[i] - expected.linear.values[i]) > 1e-3;
  EXPECT_LT(different, turned.linear.values.size() / 200) << "but for rays along edges";
}

// An emitter shines through in the picture, but its pixels are none of the object's.
TEST(GBuffer, EmittersAreSeenButNotCounted) {
  const formats::Pack pack = tests::spherePack(2, 24);
  const auto camera = transport::frameSphere(transport::boundingSphere(pack.mesh), 0, 0, 35, 1.5);
  transport::EmitterMesh emitters;
  emitters.mesh.positions = {{-0.2F, -0.2F, 1.5F}, {0.2F, -0.2F, 1.5F}, {0, 0.3F, 1.5F}};
  emitters.mesh.triangles = {{0, 1, 2}};
  emitters.radiance.assign(3, {7, 8, 9});
  const std::vector<Float3> white(pack.mesh.vertexCount(), {1, 1, 1});
  const Picture picture =
      pictureOf(traceGBuffer(pack.mesh, emitters, Eigen::Matrix3d::Identity(), camera, kGrid),
                transport::interpolated(pack.mesh.triangles, white),
                transport::interpolated(emitters.mesh.triangles, emitters.radiance));
  const std::size_t center = 20 * 60 + 30;
  EXPECT_EQ(picture.linear.values[4 * center], 7);
  EXPECT_EQ(picture.linear.values[4 * center + 3], 1);
  EXPECT_FALSE(picture.covered[center]);
  const std::size_t aside = 20 * 60 + 38;
  EXPECT_FLOAT_EQ(picture.linear.values[4 * aside], 1);
  EXPECT_TRUE(picture.covered[aside]);
}

}  // namespace
}  // namespace bakelight::report
