#include "surface/inside_out.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "surface/metrics.h"
#include "surface/repair.h"
#include "tests/support/shapes.h"
#include "tools/simplify/surface_words.h"

namespace bakelight::simplify {
namespace {

struct Ball {
  double radius;
  bool inside_out = false;
  Vec3 center = Vec3::Zero();
};

// Spheres of 320 triangles each, in this order.
WorkingMesh balls(const std::vector<Ball>& all) {
  formats::TriangleMesh mesh;
  for (const Ball& ball : all) {
    formats::TriangleMesh sphere = tests::icosphere(2, ball.radius, ball.center);
    if (ball.inside_out) {
      for (Triangle& t : sphere.triangles) std::swap(t[0], t[1]);
    }
    tests::append(mesh, sphere);
  }
  return workingMesh(mesh);
}

// Volume of the polyhedron that stands for the unit ball.
double unitVolume() {
  return volume(balls({{1}}));
}

// Of the repaired mesh, in unit balls; the number of turned components is expected.
double repairedVolume(const std::vector<Ball>& all, std::int64_t turned) {
  WorkingMesh mesh = balls(all);
  const RepairCounts counts = repair(mesh, 0);
  EXPECT_EQ(counts.inside_out_components, turned);
  EXPECT_EQ(counts.reoriented_triangles, 0);
  EXPECT_EQ(mesh.triangles.size(), 320 * all.size());
  return volume(mesh) / unitVolume();
}

constexpr bool kInsideOut = true;
// Vertices are single precision.
constexpr double kTolerance = 1e-5;

TEST(InsideOut, AHollowBallKeepsItsCavity) {
  EXPECT_NEAR(repairedVolume({{2}, {1, kInsideOut}}, 0), 8 - 1, kTolerance);
  EXPECT_NEAR(repairedVolume({{1, kInsideOut, {0.5, 0.3, -0.2}}, {2}}, 0), 8 - 1, kTolerance);
}

TEST(InsideOut, AHollowBallInsideOutTurnsAsAWhole) {
  EXPECT_NEAR(repairedVolume({{2, kInsideOut}, {1}}, 2), 8 - 1, kTolerance);
}

TEST(InsideOut, ABallInACavityStays) {
  EXPECT_NEAR(repairedVolume({{1}, {4}, {2, kInsideOut}}, 0), 64 - 8 + 1, kTolerance);
  EXPECT_NEAR(repairedVolume({{1, kInsideOut}, {4, kInsideOut}, {2}}, 3), 64 - 8 + 1, kTolerance);
}

TEST(InsideOut, ABallInsideOutTurns) {
  EXPECT_NEAR(repairedVolume({{1, kInsideOut}}, 1), 1, kTolerance);
}

TEST(InsideOut, ABallInsideOutBesideARightOneTurns) {
  EXPECT_NEAR(repairedVolume({{1}, {1, kInsideOut, {3, 0, 0}}}, 1), 2, kTolerance);
  // Within the other's bounding box, yet outside of it.
  EXPECT_NEAR(repairedVolume({{4}, {1, kInsideOut, {2.9, 2.9, 2.9}}}, 1), 64 + 1, kTolerance);
}

TEST(InsideOut, ARightBallInARightOneStays) {
  EXPECT_NEAR(repairedVolume({{2}, {1}}, 0), 8 + 1, kTolerance);
  // The search runs only where something is inside out.
  EXPECT_NEAR(repairedVolume({{2}, {1}, {1, kInsideOut, {5, 0, 0}}}, 1), 8 + 1 + 1, kTolerance);
}

TEST(InsideOut, OpenSurfacesAreLeftAndHoldNothing) {
  WorkingMesh mesh = balls({{2}, {1, kInsideOut}});
  mesh.triangles.erase(mesh.triangles.begin());  // a hole in the outer one
  EXPECT_EQ(repair(mesh, 0).inside_out_components, 1);
  mesh = balls({{1, kInsideOut}});
  mesh.triangles.pop_back();
  EXPECT_EQ(repair(mesh, 0).inside_out_components, 0);
}

}  // namespace
}  // namespace bakelight::simplify
