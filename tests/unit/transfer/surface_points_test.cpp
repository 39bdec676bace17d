#include "tools/transfer/surface_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "tests/support/shapes.h"
#include "tests/unit/transfer/bake.h"

namespace bakelight::transfer {
namespace {

using namespace bakelight::tests;

// A box whose faces have vertices and normals of their own, as simplify makes them along creases.
TriangleMesh creasedBox(bool inward) {
  TriangleMesh box;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      const Vec3 n = sign * Vec3::Unit(axis), x = Vec3::Unit((axis + 1) % 3), y = n.cross(x);
      const auto base = static_cast<std::uint32_t>(box.vertexCount());
      for (const auto& [i, j] : std::array<std::pair<int, int>, 4>{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}}) {
        box.positions.push_back(float3(n + i * x + j * y));
        box.normals.push_back(float3(n));
      }
      box.triangles.push_back({base, base + 1, base + 2});
      box.triangles.push_back({base, base + 2, base + 3});
    }
  return inward ? insideOut(box) : box;
}

TEST(SurfacePoints, FramesAreOrthonormalAndRightHanded) {
  const TriangleMesh sphere = icosphere(3);
  const auto tangents = vertexTangents(sphere);
  ASSERT_EQ(tangents.size(), sphere.vertexCount());
  for (std::size_t v = 0; v < tangents.size(); ++v) {
    const Vec3 t(tangents[v][0], tangents[v][1], tangents[v][2]);
    EXPECT_NEAR(t.norm(), 1, 1e-6);
    EXPECT_NEAR(t.dot(vec3(sphere.normals[v])), 0, 1e-6);
    const Eigen::Matrix3d local = localFromObject(sphere.normals[v], tangents[v]);
    EXPECT_NEAR((local * local.transpose() - Eigen::Matrix3d::Identity()).norm(), 0, 1e-12);
    EXPECT_NEAR(local.determinant(), 1, 1e-12);
    EXPECT_NEAR((local * vec3(sphere.normals[v]).normalized() - Vec3::UnitZ()).norm(), 0, 1e-12);
  }
}

// Off a wall along its normal, a vertex at the foot of the wall would still lie in the floor's plane.
TEST(SurfacePoints, CreaseVerticesSeeTheirOwnSideOnly) {
  // Inside a closed room nothing escapes, not even along its edges; outside a box nothing is blocked.
  const Transfer room = bake(creasedBox(true), {.order = 3});
  EXPECT_EQ(room.fully_blocked_vertices, 24u);
  const Transfer box = bake(creasedBox(false), {.order = 3});
  EXPECT_EQ(box.blocked_rays, 0u);
}

TEST(SurfacePoints, ClosedPartsAreDarkFromBehindAndOpenOnesHaveBacks) {
  TriangleMesh scene = creasedBox(false);  // creases are no borders
  append(scene, icosphere(1, 0.1, Vec3(5, 0, 0)));
  for (const auto& sides : sidesFromBehind(scene)) EXPECT_EQ(sides[0], kDarkSide);

  TriangleMesh lidless = creasedBox(false);
  lidless.triangles.resize(10);
  append(lidless, icosphere(1, 0.1, Vec3(5, 0, 0)));
  const auto mixed = sidesFromBehind(lidless);
  ASSERT_EQ(mixed.size(), lidless.triangleCount());
  const auto count = static_cast<std::uint32_t>(lidless.vertexCount());
  for (std::size_t t = 0; t < mixed.size(); ++t)
    for (std::size_t corner = 0; corner < 3; ++corner)
      EXPECT_EQ(mixed[t][corner], t < 10 ? lidless.triangles[t][corner] + count : kDarkSide);
}

TEST(SurfacePoints, BehindASheetGivenTwiceIsItsOtherSide) {
  TriangleMesh sheet;
  sheet.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  sheet.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, -1}, {0, 0, -1}, {0, 0, -1}};
  sheet.triangles = {{0, 1, 2}, {5, 4, 3}};
  const std::vector<formats::Triangle> expected = {{3, 4, 5}, {2, 1, 0}};
  EXPECT_EQ(sidesFromBehind(sheet), expected);
}

}  // namespace
}  // namespace bakelight::transfer
