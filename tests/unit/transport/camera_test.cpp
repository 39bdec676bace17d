#include "transport/camera.h"

#include <gtest/gtest.h>

namespace bakelight::transport {
namespace {

OrbitCamera someCamera() {
  OrbitCamera camera;
  camera.target = Vec3(1, 2, 3);
  camera.distance = 4;
  camera.yaw_deg = 30;
  camera.pitch_deg = -20;
  camera.field_of_view_deg = 40;
  return camera;
}

TEST(OrbitCamera, YawZeroStandsAtPlusZ) {
  OrbitCamera camera;
  camera.distance = 2;
  EXPECT_LT((camera.eye() - Vec3(0, 0, 2)).norm(), 1e-12);
  camera.yaw_deg = 90;
  EXPECT_LT((camera.eye() - Vec3(2, 0, 0)).norm(), 1e-12);
  camera.pitch_deg = 30;
  EXPECT_NEAR(camera.eye().y(), 1, 1e-12);
}

// A point projected by the matrices lies on the ray through the pixel where it lands.
TEST(OrbitCamera, MatricesAndRaysAgree) {
  const OrbitCamera camera = someCamera();
  const BoundingSphere bounds{camera.target, 1};
  const int width = 640, height = 480;
  const Eigen::Matrix4d clip_from_world =
      camera.clipFromView(static_cast<double>(width) / height, bounds) * camera.viewFromWorld();
  for (const Vec3& point : {Vec3(1, 2, 3), Vec3(1.5, 2.2, 2.7), Vec3(0.6, 1.5, 3.4)}) {
    const Eigen::Vector4d clip = clip_from_world * point.homogeneous();
    const Vec3 ndc = clip.head<3>() / clip.w();
    EXPECT_LT(ndc.cwiseAbs().maxCoeff(), 1);
    const Vec3 direction =
        camera.directionThrough((ndc.x() + 1) / 2 * width, (1 - ndc.y()) / 2 * height, width, height);
    EXPECT_LT((direction - (point - camera.eye()).normalized()).norm(), 1e-12);
  }
}

TEST(OrbitCamera, FramesTheSphereForWideAndTallPictures) {
  const BoundingSphere bounds{Vec3(5, 0, 0), 2};
  for (const double aspect : {0.4, 1.0, 2.5}) {
    const OrbitCamera camera = frameSphere(bounds, 20, 10, 40, aspect);
    // The sphere's outline is at sin(angle) = radius / distance; the narrower half view must hold it.
    const double half_vertical = 20 * M_PI / 180,
                 half_horizontal = std::atan(std::tan(half_vertical) * aspect);
    EXPECT_LT(std::asin(bounds.radius / camera.distance), std::min(half_vertical, half_horizontal));
    EXPECT_LT((camera.target - bounds.center).norm(), 1e-12);
  }
}

TEST(BoundingSphere, HoldsEveryVertex) {
  formats::TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {1, 1, -5}};
  const BoundingSphere bounds = boundingSphere(mesh);
  for (const auto& position : mesh.positions)
    EXPECT_LE((vec3(position) - bounds.center).norm(), bounds.radius);
  EXPECT_EQ(boundingSphere({}).radius, 0);
}

}  // namespace
}  // namespace bakelight::transport
