#include "tools/survey/concavity.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <random>

#include "tests/unit/survey/bodies.h"
#include "transport/camera.h"

namespace bakelight::survey {
namespace {

using namespace bakelight::tests;

// Every vertex over every triangle, without an allowance for rounding.
double largestHeight(const TriangleMesh& mesh) {
  double largest = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 origin = vec3(mesh.positions[a]);
    const Vec3 normal =
        (vec3(mesh.positions[b]) - origin).cross(vec3(mesh.positions[c]) - origin).normalized();
    for (const auto& position : mesh.positions)
      largest = std::max(largest, normal.dot(vec3(position) - origin));
  }
  return largest / transport::boundingSphere(mesh).radius;
}

TriangleMesh bumpySphere(int subdivisions, unsigned seed, double bump) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> factor(1 - bump, 1 + bump);
  TriangleMesh mesh = icosphere(subdivisions);
  for (auto& position : mesh.positions) position = float3(vec3(position) * factor(random));
  return mesh;
}

TEST(Concavity, OfConvexBodiesIsZero) {
  const std::vector<std::pair<const char*, TriangleMesh>> bodies = {
      {"icosahedron", icosphere(0)},
      {"sphere", icosphere(5)},
      {"box", box(1)},
      {"turned box", turned(box(1))},
      {"finely divided turned box", turned(box(60))},
      {"far from the origin", turned(box(20), {1e4, -2e4, 3e4})},
      {"sphere far from the origin", icosphere(3, 1, {1e3, 0, 0})},
      {"tiny", icosphere(3, 1e-6)},
      {"huge", icosphere(3, 1e6)},
  };
  for (const auto& [name, mesh] : bodies) EXPECT_EQ(concavity(mesh), 0) << name;
}

// Fronts that have nothing above them are not blocked, whatever is behind.
TEST(Concavity, OfOpenSheetsGoesByTheirFronts) {
  EXPECT_EQ(concavity(insideOut(cavity(0.25, 16, 32))), 0) << "cap from outside";
  EXPECT_GT(concavity(cavity(0.25, 16, 32)), 1) << "cap from inside";
  EXPECT_EQ(concavity(diskFacingDown({0, 0, 0}, 1, 16)), 0);
  EXPECT_EQ(concavity(joined(diskFacingDown({0, 0, 0}, 1, 16), diskFacingDown({5, 0, 0}, 1, 16))), 0)
      << "side by side";
  EXPECT_GT(concavity(joined(diskFacingDown({0, 0, 0}, 1, 16), diskFacingDown({0, -1, 0}, 1, 16))), 0.5)
      << "one above the other";
}

TEST(Concavity, SeesWhatIsNotConvex) {
  EXPECT_GT(concavity(joined(icosphere(2), icosphere(2, 1, {3, 0, 0}))), 1) << "two bodies";
  EXPECT_GT(concavity(insideOut(icosphere(3))), 1) << "windings turned";
  EXPECT_GT(concavity(joined(icosphere(2), icosphere(2, 0.3))), 0.5) << "one within the other";
}

// Of a small dent in a fine sphere: pushed in by 1e-4, one vertex leaves its neighbours above the planes of
// the triangles around it.
TEST(Concavity, SeesOneDentedVertex) {
  TriangleMesh mesh = icosphere(5);
  ASSERT_EQ(concavity(mesh), 0);
  mesh.positions[5000] = float3(vec3(mesh.positions[5000]) * 0.998);
  EXPECT_GT(concavity(mesh), 1e-3);
}

TEST(Concavity, IsTheLargestHeightOfAll) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const TriangleMesh mesh = turned(bumpySphere(3, seed, seed < 10 ? 0.02 : 0.4));
    const double expected = largestHeight(mesh);
    ASSERT_GT(expected, 1e-3);
    EXPECT_NEAR(concavity(mesh), expected, 1e-4 * expected) << "seed " << seed;
    EXPECT_LE(concavity(mesh), expected);
  }
}

TEST(Concavity, LeavesOutTrianglesWithoutAreaAndUnusedVertices) {
  TriangleMesh mesh = icosphere(2);
  mesh.positions.push_back({0, 9, 0});  // used by none; the bounding sphere does not matter for 0
  mesh.triangles.push_back({3, 3, 7});
  mesh.triangles.push_back({3, 7, 3});
  EXPECT_EQ(concavity(mesh), 0);
  EXPECT_EQ(concavity(TriangleMesh()), 0);
}

TEST(Concavity, IsTheSameWithAnyNumberOfThreads) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    const TriangleMesh mesh = bumpySphere(5, seed, 0.1);
    double one = 0;
    {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
      one = concavity(mesh);
    }
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
    EXPECT_EQ(concavity(mesh), one);
    EXPECT_GT(one, 0);
  }
}

}  // namespace
}  // namespace bakelight::survey
