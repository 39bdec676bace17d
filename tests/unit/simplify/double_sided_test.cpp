#include "tools/simplify/double_sided.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace bakelight::simplify {
namespace {

using namespace bakelight::tests;

TEST(DoubleSided, OpenPartsGetBacksAndClosedOnesDoNot) {
  TriangleMesh scene = icosphere(1);
  const std::size_t closed_vertices = scene.vertexCount(), closed_triangles = scene.triangleCount();
  append(scene, diskFacingDown(Vec3(0, 3, 0), 1, 12));
  const TriangleMesh before = scene;
  EXPECT_EQ(addBacks(scene), 12u);
  ASSERT_EQ(scene.triangleCount(), closed_triangles + 24);
  ASSERT_EQ(scene.vertexCount(), closed_vertices + 26);
  ASSERT_EQ(scene.normals.size(), scene.vertexCount());
  for (std::size_t v = before.vertexCount(); v < scene.vertexCount(); ++v) EXPECT_EQ(scene.normals[v][1], 1);
  // The same triangles, seen from the other side.
  for (std::size_t t = 0; t < 12; ++t) {
    const auto& front = before.triangles[closed_triangles + t];
    const auto& back = scene.triangles[before.triangleCount() + t];
    EXPECT_EQ(scene.positions[back[0]], scene.positions[front[0]]);
    EXPECT_EQ(scene.positions[back[1]], scene.positions[front[2]]);
    EXPECT_EQ(scene.positions[back[2]], scene.positions[front[1]]);
  }
}

TEST(DoubleSided, AClosedBodyStaysAsItIs) {
  TriangleMesh ball = icosphere(2);
  const TriangleMesh before = ball;
  EXPECT_EQ(addBacks(ball), 0u);
  EXPECT_EQ(ball.triangles, before.triangles);
  EXPECT_EQ(ball.positions, before.positions);
}

}  // namespace
}  // namespace bakelight::simplify
