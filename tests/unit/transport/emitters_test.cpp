#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

#include "transport/light_rig.h"
#include "transport/polygon_light.h"

namespace bakelight::transport {
namespace {

constexpr double kPi = std::numbers::pi;
const BoundingSphere kUnitSphere = {Vec3::Zero(), 1};

formats::LightRig rigOf(std::vector<formats::Emitter> emitters) {
  formats::LightRig rig;
  rig.emitters = std::move(emitters);
  return rig;
}

formats::Emitter sphereAt(const Float3& position, double radius) {
  formats::Emitter emitter;
  emitter.shape = formats::Emitter::Shape::kSphere;
  emitter.position = position;
  emitter.radius = radius;
  return emitter;
}

formats::Emitter quadAt(const Float3& position, const Float3& normal, double size) {
  formats::Emitter emitter;
  emitter.position = position;
  emitter.normal = normal;
  emitter.width = emitter.height = size;
  return emitter;
}

ShLight seenFromCenter(const formats::LightRig& rig, int resolution, int order = 3) {
  const auto cube = renderEmitterCube(emitterMesh(rig, kUnitSphere, 0), Vec3::Zero(), resolution);
  return projectCubeMap(cube, order, "emitters");
}

Vec3 centerOf(const EmitterMesh& emitters) {
  Vec3 sum = Vec3::Zero();
  for (const Float3& position : emitters.mesh.positions) sum += vec3(position);
  return sum / static_cast<double>(emitters.mesh.vertexCount());
}

// ∫ L dω = L·Ω, and the higher bands are those of the polygon in closed form.
TEST(EmitterCube, QuadSendsRadianceTimesSolidAngle) {
  formats::Emitter quad = quadAt({0.4F, 1.5F, 2}, {-0.1F, -0.5F, -1}, 0.8);
  quad.radiance = {2, 1, 0.5F};
  const EmitterMesh mesh = emitterMesh(rigOf({quad}), kUnitSphere, 0);
  std::vector<Vec3> corners;
  for (const Float3& position : mesh.mesh.positions) corners.push_back(vec3(position));
  const ShLight expected = polygonLight(5, corners, quad.radiance);
  const ShLight seen = seenFromCenter(rigOf({quad}), 256, 5);
  EXPECT_NEAR(expected[0][0] * std::sqrt(4 * kPi), 2 * polygonSolidAngle(corners), 1e-6);
  // Texels of 256² faces: a rim of about 60 texels a side is right to half a texel on average.
  for (std::size_t i = 0; i < seen.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(seen[i][c], expected[i][c], 0.01 * expected[0][c]) << "coefficient " << i;
}

TEST(EmitterCube, QuadShinesOnBothSidesAndDimsWithTheSquareOfDistance) {
  const auto mean = [](const formats::Emitter& quad) { return seenFromCenter(rigOf({quad}), 256)[0][1]; };
  const float front = mean(quadAt({0, 0, 8}, {0, 0, -1}, 1));
  EXPECT_GT(front, 0);
  EXPECT_FLOAT_EQ(mean(quadAt({0, 0, 8}, {0, 0, 1}, 1)), front);
  EXPECT_NEAR(mean(quadAt({0, 0, 4}, {0, 0, -1}, 1)) / front, 4, 0.15);
}

// A sphere of radius r at distance d is the disk of half angle asin(r/d).
TEST(EmitterCube, SphereIsADiskLight) {
  for (const double distance : {1.5, 3.0, 6.0}) {
    const Vec3 axis = Vec3(0.5, -0.7, 0.4).normalized();
    const ShLight seen = seenFromCenter(rigOf({sphereAt(float3(distance * axis), 1)}), 192, 5);
    const ShLight expected = diskLight(5, axis, std::asin(1 / distance), {1, 1, 1});
    for (std::size_t i = 0; i < seen.size(); ++i)
      EXPECT_NEAR(seen[i][0], expected[i][0], 0.012 * expected[0][0]) << "distance " << distance;
  }
}

TEST(EmitterCube, NearerSpheresShineMoreUpToTheCenter) {
  double before = 0;
  for (double distance = 4; distance >= 0; distance -= 0.05) {
    const ShLight seen = seenFromCenter(rigOf({sphereAt({0, 0, static_cast<float>(distance)}, 0.5)}), 64);
    for (const Float3& coefficient : seen)
      for (const float value : coefficient) ASSERT_TRUE(std::isfinite(value));
    EXPECT_GE(seen[0][0], before) << "distance " << distance;
    before = seen[0][0];
  }
  EXPECT_NEAR(before, std::sqrt(4 * kPi), 1e-5);  // inside it: the uniform light
}

TEST(EmitterCube, ExtremeEmittersStayFinite) {
  const std::vector<formats::Emitter> emitters = {
      quadAt({0, 0, 0}, {0, 1, 0}, 1),      // through the centre
      quadAt({0, 0, 1e-7F}, {0, 0, 1}, 1),  // touching it
      sphereAt({0, 0, 0.5F}, 0.5),          // touching it
      sphereAt({0, 0, 0}, 1e-6),            // tiny, around it
      quadAt({0, 0, 1}, {0, 0, 1}, 1e6),    // huge
      sphereAt({0, 0, -2e6F}, 1e6),         // huge and far
      quadAt({0, 3, 0}, {0, 1, 0}, 1e-6),   // tiny: between the rays
  };
  for (const auto& emitter : emitters) {
    const ShLight seen = seenFromCenter(rigOf({emitter}), 32);
    for (const Float3& coefficient : seen)
      for (const float value : coefficient) ASSERT_TRUE(std::isfinite(value));
    EXPECT_GE(seen[0][0], 0);
    EXPECT_LE(seen[0][0], std::sqrt(4 * kPi) * 1.00001);
  }
  const ShLight wall = seenFromCenter(rigOf({quadAt({0, 0, 1}, {0, 0, 1}, 1e6)}), 32);
  EXPECT_NEAR(wall[0][0], std::sqrt(4 * kPi) / 2, 0.01);  // half of everything
}

TEST(EmitterCube, NearerEmitterHidesTheFarther) {
  formats::Emitter near = quadAt({0, 2, 0}, {0, 1, 0}, 1), far = quadAt({0, 4, 0}, {0, 1, 0}, 1);
  near.radiance = {1, 0, 0};
  far.radiance = {0, 1, 0};
  const ShLight both = seenFromCenter(rigOf({far, near}), 64);
  EXPECT_GT(both[0][0], 0);
  EXPECT_EQ(both[0][1], 0);
}

TEST(EmitterCube, NothingThereIsBlack) {
  for (const Float3& coefficient : seenFromCenter(rigOf({}), 8)) EXPECT_EQ(coefficient, (Float3{0, 0, 0}));
}

TEST(EmitterMesh, SphereHasItsAreaAndRadius) {
  const EmitterMesh sphere = emitterMesh(rigOf({sphereAt({1, 2, 3}, 2)}), kUnitSphere, 0);
  ASSERT_EQ(sphere.mesh.triangleCount(), 1280u);
  double area = 0;
  for (const auto& [a, b, c] : sphere.mesh.triangles) {
    const Vec3 p = vec3(sphere.mesh.positions[a]), q = vec3(sphere.mesh.positions[b]),
               r = vec3(sphere.mesh.positions[c]);
    area += (q - p).cross(r - p).norm() / 2;
    const Vec3 plane = (q - p).cross(r - p).normalized();
    EXPECT_NEAR(plane.dot(p - Vec3(1, 2, 3)), 2, 0.003 * 2);  // the nearest point of the triangle's plane
  }
  EXPECT_NEAR(area, 4 * kPi * 4, 1e-4);
  for (std::size_t v = 0; v < sphere.mesh.vertexCount(); ++v) {
    EXPECT_NEAR((vec3(sphere.mesh.positions[v]) - Vec3(1, 2, 3)).norm(), 2, 0.003 * 2);
    EXPECT_NEAR(vec3(sphere.mesh.normals[v]).norm(), 1, 1e-6);
    EXPECT_EQ(sphere.radiance.at(v), (Float3{1, 1, 1}));
  }
}

TEST(EmitterMesh, QuadFacesItsNormalWithItsWidthHorizontal) {
  formats::Emitter quad = quadAt({0, 0, 0}, {1, 1, 0}, 1);
  quad.width = 4;
  quad.height = 2;
  const EmitterMesh mesh = emitterMesh(rigOf({quad}), kUnitSphere, 0);
  const auto& p = mesh.mesh.positions;
  const Vec3 across = vec3(p[1]) - vec3(p[0]), up = vec3(p[3]) - vec3(p[0]);
  EXPECT_NEAR(across.norm(), 4, 1e-6);
  EXPECT_NEAR(across.y(), 0, 1e-6);
  EXPECT_NEAR(up.norm(), 2, 1e-6);
  EXPECT_GT(up.y(), 0);
  EXPECT_LT((across.cross(up).normalized() - Vec3(1, 1, 0).normalized()).norm(), 1e-6);
}

TEST(EmitterMesh, ObjectUnitsAreThoseOfTheBoundingSphere) {
  const BoundingSphere object = {Vec3(10, 20, 30), 5};
  formats::LightRig rig = rigOf({sphereAt({1, 0, 2}, 0.5)});
  const EmitterMesh in_object = emitterMesh(rig, object, 0);
  EXPECT_LT((centerOf(in_object) - Vec3(15, 20, 40)).norm(), 1e-4);
  EXPECT_NEAR((vec3(in_object.mesh.positions[0]) - Vec3(15, 20, 40)).norm(), 2.5, 0.01);
  rig.object_units = false;
  const EmitterMesh in_world = emitterMesh(rig, object, 0);
  EXPECT_LT((centerOf(in_world) - Vec3(1, 0, 2)).norm(), 1e-5);
}

TEST(EmitterMesh, OrbitTurnsAboutItsAxis) {
  formats::Emitter quad = quadAt({2, 0, 0}, {-1, 0, 0}, 1);
  quad.motion = {
      .kind = formats::Motion::Kind::kOrbit, .axis = {0, 3, 0}, .center = {1, 0, 0}, .period_s = 4};
  const auto at = [&](double time_s) { return emitterMesh(rigOf({quad}), kUnitSphere, time_s); };
  EXPECT_LT((centerOf(at(0)) - Vec3(2, 0, 0)).norm(), 1e-6);
  EXPECT_LT((centerOf(at(1)) - Vec3(1, 0, -1)).norm(), 1e-6);  // a right-handed quarter about +Y
  EXPECT_LT((centerOf(at(2)) - Vec3(0, 0, 0)).norm(), 1e-6);
  EXPECT_LT((centerOf(at(4e6 + 1)) - Vec3(1, 0, -1)).norm(), 1e-6);
  // It keeps facing the centre.
  EXPECT_LT((vec3(at(1).mesh.normals[0]) - Vec3(0, 0, 1)).norm(), 1e-6);
}

TEST(EmitterMesh, ShuttleGoesToAndFro) {
  formats::Emitter sphere = sphereAt({0, 1, 0}, 0.1);
  sphere.motion = {.kind = formats::Motion::Kind::kShuttle, .to = {0, 5, 2}, .period_s = 2};
  const auto at = [&](double time_s) { return centerOf(emitterMesh(rigOf({sphere}), kUnitSphere, time_s)); };
  EXPECT_LT((at(0) - Vec3(0, 1, 0)).norm(), 1e-6);
  EXPECT_LT((at(1) - Vec3(0, 5, 2)).norm(), 1e-6);
  EXPECT_LT((at(0.5) - Vec3(0, 3, 1)).norm(), 1e-6);
  EXPECT_LT((at(2) - Vec3(0, 1, 0)).norm(), 1e-6);
}

TEST(EmitterMesh, MeshIsScaledPlacedAndGivenNormals) {
  formats::Emitter emitter;
  emitter.shape = formats::Emitter::Shape::kMesh;
  emitter.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  emitter.mesh.triangles = {{0, 1, 2}};
  emitter.scale = 3;
  emitter.position = {0, 0, 2};
  emitter.radiance = {4, 5, 6};
  const EmitterMesh placed = emitterMesh(rigOf({sphereAt({9, 9, 9}, 1), emitter}), kUnitSphere, 0);
  ASSERT_EQ(placed.mesh.vertexCount(), 642u + 3);
  ASSERT_EQ(placed.mesh.normals.size(), placed.mesh.vertexCount());
  EXPECT_EQ(placed.mesh.positions[643], (formats::Float3{3, 0, 2}));
  EXPECT_EQ(placed.mesh.normals[644], (formats::Float3{0, 0, 1}));
  EXPECT_EQ(placed.mesh.triangles.back(), (formats::Triangle{642, 643, 644}));
  EXPECT_EQ(placed.radiance.back(), (Float3{4, 5, 6}));
}

// Turning the rig about the object turns what the object sees.
TEST(EmitterCube, TurningTheEmittersRotatesTheLight) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.9, Vec3::UnitY()).toRotationMatrix();
  formats::Emitter quad = quadAt({0.5F, 0.3F, 2}, {0, 0.2F, -1}, 1.5);
  const ShLight before = ShRotation(4, turn).apply(seenFromCenter(rigOf({quad}), 256, 4));
  quad.position = float3(turn * vec3(quad.position));
  quad.normal = float3(turn * vec3(quad.normal));
  const ShLight after = seenFromCenter(rigOf({quad}), 256, 4);
  for (std::size_t i = 0; i < after.size(); ++i) EXPECT_NEAR(after[i][0], before[i][0], 0.01 * after[0][0]);
}

TEST(EmitterCube, SameBytesWithAnyNumberOfThreads) {
  const EmitterMesh mesh =
      emitterMesh(rigOf({sphereAt({0, 1, 2}, 0.7), quadAt({1, 0, 0}, {1, 0, 0}, 1)}), kUnitSphere, 0.3);
  const auto many = renderEmitterCube(mesh, Vec3::Zero(), 48).values;
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(renderEmitterCube(mesh, Vec3::Zero(), 48).values, many);
}

}  // namespace
}  // namespace bakelight::transport
