#include "surface/repair.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "surface/half_edge_mesh.h"
#include "surface/metrics.h"
#include "tests/support/shapes.h"
#include "tools/simplify/surface_words.h"

namespace bakelight::simplify {
namespace {

// Each corner of each triangle as a vertex of its own.
WorkingMesh soupOf(const WorkingMesh& mesh) {
  WorkingMesh soup;
  for (const Triangle& t : mesh.triangles) {
    const auto base = static_cast<std::uint32_t>(soup.positions.size());
    for (const std::uint32_t i : t) soup.positions.push_back(mesh.positions[i]);
    soup.triangles.push_back({base, base + 1, base + 2});
  }
  return soup;
}

WorkingMesh sphere(int subdivisions) {
  return workingMesh(tests::icosphere(subdivisions));
}

WorkingMesh tetrahedron(const Vec3& apex = {0, 0, 1}) {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, apex}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
}

TEST(Repair, LeavesACleanMeshAsItIs) {
  WorkingMesh mesh = sphere(2);
  const WorkingMesh before = mesh;
  EXPECT_TRUE(repair(mesh, 0).clean());
  EXPECT_EQ(mesh.triangles, before.triangles);
  EXPECT_EQ(mesh.positions, before.positions);
}

TEST(Repair, WeldsATriangleSoupIntoAClosedSphere) {
  WorkingMesh mesh = soupOf(sphere(2));
  EXPECT_EQ(repair(mesh, 0).welded_vertices, 3 * 320 - 162);
  const Topology result = topology(mesh);
  EXPECT_TRUE(result.closed());
  EXPECT_EQ(result.components, 1);
  EXPECT_EQ(result.euler_characteristic, 2);
}

TEST(Repair, WeldsWithinTheToleranceOnly) {
  for (const double jitter : {0.9e-3, 1.1e-3}) {
    WorkingMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, jitter, 0}, {1, 1, 0}, {0, 1, 0}},
                     {{0, 1, 2}, {3, 4, 5}}};
    EXPECT_EQ(repair(mesh, 1e-3).welded_vertices, jitter < 1e-3 ? 2 : 1) << jitter;
  }
}

TEST(Repair, CountsDuplicateReversedAndRepeatedIndexTrianglesAndIsolatedVertices) {
  WorkingMesh mesh = tetrahedron();
  mesh.triangles.push_back({1, 3, 0});  // the second, turned
  mesh.triangles.push_back({2, 1, 3});  // the third, reversed
  mesh.triangles.push_back({1, 1, 3});
  mesh.positions.push_back({5, 5, 5});
  const RepairCounts counts = repair(mesh, 0);
  EXPECT_EQ(counts.duplicate_triangles, 1);
  EXPECT_EQ(counts.reversed_triangles, 1);
  EXPECT_EQ(counts.repeated_index_triangles, 1);
  EXPECT_EQ(counts.isolated_vertices, 1);
  EXPECT_EQ(mesh.triangles, tetrahedron().triangles);
  EXPECT_EQ(mesh.positions.size(), 4u);
}

TEST(Repair, TurnsTheFewTrianglesThatDisagree) {
  WorkingMesh mesh = sphere(2);
  const std::vector<Triangle> before = mesh.triangles;
  for (const std::size_t t : {3u, 77u, 200u}) std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
  EXPECT_EQ(repair(mesh, 0).reoriented_triangles, 3);
  EXPECT_NEAR(volume(mesh), volume({mesh.positions, before}), 1e-12);
}

TEST(Repair, TurnsInsideOutComponentsAndCountsThem) {
  WorkingMesh mesh = sphere(1);
  const double expected = volume(mesh);
  for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
  const RepairCounts counts = repair(mesh, 0);
  EXPECT_EQ(counts.inside_out_components, 1);
  EXPECT_EQ(counts.reoriented_triangles, 0);
  EXPECT_NEAR(volume(mesh), expected, 1e-12);
}

TEST(Repair, PartsAFinFromTheSurfaceItStandsOn) {
  WorkingMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, -1, 0}, {0.5, 0, 1}},
                   {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}};
  const RepairCounts counts = repair(mesh, 0);
  EXPECT_EQ(counts.non_manifold_edges, 1);
  EXPECT_EQ(counts.non_manifold_vertices, 2);
  EXPECT_EQ(counts.added_vertices, 2);
  EXPECT_EQ(topology(mesh).components, 2);
  // The flat pair stays together.
  EXPECT_EQ(mesh.triangles[0], (Triangle{0, 1, 2}));
  EXPECT_EQ(mesh.triangles[1], (Triangle{1, 0, 3}));
}

TEST(Repair, PartsTwoTetrahedraThatShareAVertex) {
  WorkingMesh mesh = tetrahedron();
  for (const Vec3& p : {Vec3(1, 0, 2), Vec3(0, 1, 2), Vec3(0, 0, 2)}) mesh.positions.push_back(p);
  for (const Triangle& t : {Triangle{3, 5, 4}, Triangle{3, 4, 6}, Triangle{4, 5, 6}, Triangle{5, 3, 6}}) {
    mesh.triangles.push_back(t);
  }
  const RepairCounts counts = repair(mesh, 0);
  EXPECT_EQ(counts.non_manifold_edges, 0);
  EXPECT_EQ(counts.non_manifold_vertices, 1);
  EXPECT_EQ(topology(mesh).components, 2);
  EXPECT_TRUE(topology(mesh).closed());
}

TEST(Repair, CutsAMoebiusStripOnce) {
  WorkingMesh mesh;
  constexpr std::uint32_t kSteps = 24;
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const double angle = 2 * M_PI * i / kSteps;
    const Vec3 center(std::cos(angle), std::sin(angle), 0);
    const Vec3 across = 0.2 * (std::cos(angle / 2) * center + std::sin(angle / 2) * Vec3(0, 0, 1));
    mesh.positions.push_back(center - across);
    mesh.positions.push_back(center + across);
  }
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const bool last = i + 1 == kSteps;
    const std::uint32_t a = 2 * i, b = a + 1, c = last ? 1 : a + 2, d = last ? 0 : a + 3;
    mesh.triangles.push_back({a, c, b});
    mesh.triangles.push_back({b, c, d});
  }
  EXPECT_EQ(repair(mesh, 0).one_sided_cuts, 1);
  EXPECT_EQ(topology(mesh).components, 1);
  EXPECT_EQ(topology(mesh).euler_characteristic, 1);  // a strip
}

TEST(Repair, FlipsAwayATriangleWithoutArea) {
  // The corner 4 lies on the side from 0 to 1; its triangle fills the T-junction.
  WorkingMesh mesh{{{0, 0, 0}, {2, 0, 0}, {1, 1, 0}, {1, -1, 0}, {1, 0, 0}},
                   {{0, 4, 2}, {4, 1, 2}, {1, 0, 3}, {0, 1, 4}}};
  EXPECT_EQ(repair(mesh, 0).zero_area_triangles, 1);
  EXPECT_EQ(mesh.triangles.size(), 4u);
  EXPECT_NEAR(area(mesh), 2, 1e-12);
  EXPECT_EQ(topology(mesh).boundary_edges, 4);
  EXPECT_GT(angleQuality(mesh).worst_min_angle_deg, 40);
}

// Random soups of few vertices are non-manifold nearly everywhere. halfEdgeMesh throws if anything is left of
// that.
TEST(Repair, MakesManifoldsOfRandomSoups) {
  std::mt19937 engine(1);
  const auto random = [&](std::uint32_t below) { return static_cast<std::uint32_t>(engine()) % below; };
  std::int64_t repaired = 0;
  for (int trial = 0; trial < 300; ++trial) {
    WorkingMesh mesh;
    const std::uint32_t vertices = 4 + random(12), triangles = 1 + random(60);
    for (std::uint32_t i = 0; i < vertices; ++i) {
      const double x = random(8), y = random(8), z = random(8);
      mesh.positions.push_back({x, y, z});
    }
    for (std::uint32_t t = 0; t < triangles; ++t) {
      const std::uint32_t a = random(vertices), b = random(vertices), c = random(vertices);
      mesh.triangles.push_back({a, b, c});
    }
    repaired += repair(mesh, 0).non_manifold_edges;
    ASSERT_NO_THROW(halfEdgeMesh(mesh)) << "trial " << trial;
  }
  EXPECT_GT(repaired, 1000);
}

}  // namespace
}  // namespace bakelight::simplify
