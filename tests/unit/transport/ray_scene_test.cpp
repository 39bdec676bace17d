#include "transport/ray_scene.h"

#include <gtest/gtest.h>

#include "transport/directions.h"

namespace bakelight::transport {
namespace {

formats::TriangleMesh unitSquareAtHeightOne() {
  formats::TriangleMesh mesh;
  mesh.positions = {{-1, 1, -1}, {1, 1, -1}, {1, 1, 1}, {-1, 1, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}};
  return mesh;
}

TEST(RayScene, OccludedMatchesTheGeometry) {
  const RayScene scene(unitSquareAtHeightOne());
  RayBundle bundle;
  const std::vector<Vec3> directions = sphereDirections(1001);  // not a multiple of the packet
  for (const Vec3& d : directions) bundle.push(float3(d));
  std::vector<std::uint8_t> blocked(bundle.size(), 7);
  scene.occluded({0, 0, 0}, bundle, 0, blocked);
  int hits = 0;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const Vec3& d = directions[i];
    const bool expected = d.y() > 0 && std::abs(d.x()) < d.y() && std::abs(d.z()) < d.y();
    EXPECT_EQ(blocked[i], expected ? 1 : 0) << d.transpose();
    hits += blocked[i];
  }
  // The square is one face of a cube around the origin: a sixth of the sphere.
  EXPECT_NEAR(hits / 1001.0, 1 / 6.0, 0.01);
}

TEST(RayScene, HitsAreTheSameAtEveryScale) {
  for (const float scale : {1e-14F, 1e-9F, 1.0F, 1e9F, 5e14F}) {
    formats::TriangleMesh mesh = unitSquareAtHeightOne();
    for (auto& position : mesh.positions)
      for (float& value : position) value *= scale;
    const RayScene scene(mesh);
    const Hit hit = scene.nearestHit(Vec3(0.25, -1, 0.5) * scale, {0, 1, 0});
    ASSERT_TRUE(hit.valid) << scale;
    EXPECT_NEAR(hit.distance / scale, 2, 1e-5) << scale;
    EXPECT_TRUE(scene.occluded(Vec3(0.25, -1, 0.5) * scale, {0, 1, 0}, 2.1F * scale)) << scale;
    EXPECT_FALSE(scene.occluded(Vec3(0.25, -1, 0.5) * scale, {0, 1, 0}, 1.9F * scale)) << scale;
    RayBundle up;
    up.push({0, 1, 0});
    HitBundle hits(1);
    scene.nearestHits({0, -scale, 0.25F * scale}, up, 0, 1, hits);
    EXPECT_EQ(hits.blocked[0], 1) << scale;
    EXPECT_NEAR(hits.distance[0] / scale, 2, 1e-5) << scale;
    std::vector<std::uint8_t> blocked(1);
    scene.occluded({0, -scale, 0.25F * scale}, up, 2.1F * scale, blocked);
    EXPECT_EQ(blocked[0], 0) << scale;
  }
}

TEST(RayScene, BothSidesBlockAndNearDistanceCounts) {
  const RayScene scene(unitSquareAtHeightOne());
  RayBundle bundle;
  bundle.push({0, -1, 0});
  std::vector<std::uint8_t> blocked(1);
  scene.occluded({0.1f, 3, 0.2f}, bundle, 0, blocked);
  EXPECT_EQ(blocked[0], 1);
  scene.occluded({0.1f, 3, 0.2f}, bundle, 2.5f, blocked);
  EXPECT_EQ(blocked[0], 0);
}

TEST(RayScene, NearestHitGivesTriangleAndBarycentrics) {
  const auto mesh = unitSquareAtHeightOne();
  const RayScene scene(mesh);
  const Hit hit = scene.nearestHit(Vec3(0.25, 0, 0.5), Vec3(0, 1, 0));
  ASSERT_TRUE(hit.valid);
  EXPECT_NEAR(hit.distance, 1, 1e-6);
  const auto& triangle = mesh.triangles[hit.triangle];
  const Vec3 point = (1 - hit.u - hit.v) * vec3(mesh.positions[triangle[0]]) +
                     hit.u * vec3(mesh.positions[triangle[1]]) + hit.v * vec3(mesh.positions[triangle[2]]);
  EXPECT_LT((point - Vec3(0.25, 1, 0.5)).norm(), 1e-6);
  EXPECT_FALSE(scene.nearestHit(Vec3(3, 0, 0), Vec3(0, 1, 0)).valid);
}

TEST(RayScene, EmptyAndDegenerateMeshesBlockNothing) {
  RayBundle bundle;
  bundle.push({0, 1, 0});
  std::vector<std::uint8_t> blocked(1, 1);
  RayScene(formats::TriangleMesh{}).occluded({0, 0, 0}, bundle, 0, blocked);
  EXPECT_EQ(blocked[0], 0);
  formats::TriangleMesh line;
  line.positions = {{0, 1, 0}, {1, 1, 0}, {2, 1, 0}};
  line.triangles = {{0, 1, 2}, {0, 0, 1}};
  RayScene(line).occluded({0, 0, 0}, bundle, 0, blocked);
  EXPECT_EQ(blocked[0], 0);
}

}  // namespace
}  // namespace bakelight::transport
