#include "tools/simplify/normals.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace bakelight::simplify {
namespace {

using transport::vec3;

WorkingMesh cube() {
  WorkingMesh mesh;
  for (int i = 0; i < 8; ++i) mesh.positions.push_back(Vec3(i & 1, i >> 1 & 1, i >> 2 & 1));
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

TEST(Normals, OfACubeAreThoseOfItsFaces) {
  const ShadedMesh shaded = withNormals(cube(), 60, 0);
  EXPECT_EQ(shaded.split_vertices, 16);
  ASSERT_EQ(shaded.mesh.vertexCount(), 24u);
  for (std::size_t t = 0; t < 12; ++t) {
    const Vec3 face = cube().areaVector(t).normalized();
    for (const std::uint32_t v : shaded.mesh.triangles[t]) {
      EXPECT_NEAR((vec3(shaded.mesh.normals[v]) - face).norm(), 0, 1e-7);
    }
  }
}

TEST(Normals, OfASmoothedCubePointAlongTheDiagonals) {
  const ShadedMesh shaded = withNormals(cube(), 100, 0);
  EXPECT_EQ(shaded.split_vertices, 0);
  for (std::size_t v = 0; v < 8; ++v) {
    // Angle weights make the way the squares are cut irrelevant.
    const Vec3 diagonal = (vec3(shaded.mesh.positions[v]) - Vec3(0.5, 0.5, 0.5)).normalized();
    EXPECT_NEAR((vec3(shaded.mesh.normals[v]) - diagonal).norm(), 0, 1e-6);
  }
}

TEST(Normals, OfAFineSphereAreItsRadii) {
  const formats::TriangleMesh sphere = tests::icosphere(4);
  const ShadedMesh shaded = withNormals(workingMesh(sphere), 60, 0);
  EXPECT_EQ(shaded.split_vertices, 0);
  ASSERT_EQ(shaded.mesh.normals.size(), sphere.vertexCount());
  for (std::size_t v = 0; v < sphere.vertexCount(); ++v) {
    EXPECT_NEAR((vec3(shaded.mesh.normals[v]) - vec3(sphere.positions[v])).norm(), 0, 5e-3);
  }
}

TEST(Normals, OfOneTriangleAreItsOwn) {
  const ShadedMesh shaded = withNormals({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}, 60, 0);
  EXPECT_EQ(shaded.split_vertices, 0);
  for (const formats::Float3& n : shaded.mesh.normals) EXPECT_EQ(n, (formats::Float3{0, 0, 1}));
}

}  // namespace
}  // namespace bakelight::simplify
