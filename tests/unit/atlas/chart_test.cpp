#include "tools/atlas/charts/chart.h"

#include <numeric>

#include "bodies.h"
#include "flat_shapes.h"
#include "formats/error.h"

namespace bakelight::atlas {
namespace {

using tests::wholeChart;

TEST(Surface, IsOfUnitAreaAndKeepsNeighborsAcrossSplitVertices) {
  formats::TriangleMesh mesh;
  // Two triangles of one square, each with vertices of its own, as along a crease.
  mesh.positions = {{0, 0, 5}, {2, 0, 5}, {2, 2, 5}, {0, 0, 5}, {2, 2, 5}, {0, 2, 5}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  const Surface surface = surfaceOf(mesh, "square.ply");
  EXPECT_EQ(surface.positions.size(), 4u);
  EXPECT_DOUBLE_EQ(surface.areas[0] + surface.areas[1], 1);
  EXPECT_DOUBLE_EQ(surface.scale, 0.5);
  EXPECT_EQ(surface.neighbors[0], (std::array<std::int32_t, 3>{-1, -1, 1}));
  EXPECT_EQ(surface.neighbors[1], (std::array<std::int32_t, 3>{0, -1, -1}));
  EXPECT_EQ(surface.border_edges, 4);
}

TEST(Surface, CountsWhatIsNoOrdinaryEdge) {
  formats::TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {3, 0, 0}};
  // Three triangles share edge 0–1, then one that faces the other way across 1–2, then one without area.
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {1, 2, 5}, {0, 1, 5}};
  const Surface surface = surfaceOf(mesh, "odd.ply");
  EXPECT_EQ(surface.non_manifold_edges, 1);
  EXPECT_EQ(surface.misoriented_edges, 1);
  EXPECT_EQ(surface.degenerate_triangles, 1);
  EXPECT_EQ(surface.source_triangles, (std::vector<std::uint32_t>{0, 1, 2, 3}));
  for (const auto& neighbors : surface.neighbors)
    EXPECT_EQ(neighbors, (std::array<std::int32_t, 3>{-1, -1, -1}));
}

TEST(Surface, RefusesWhatIsNoSurface) {
  formats::TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  mesh.triangles = {{0, 1, 2}};
  EXPECT_THROW(surfaceOf(mesh, "line.ply"), Error);
  mesh.positions[2] = {0, std::nanf(""), 0};
  EXPECT_THROW(surfaceOf(mesh, "nan.ply"), Error);
  mesh.positions[2] = {0, 1, 0};
  mesh.triangles = {{0, 1, 3}};
  EXPECT_THROW(surfaceOf(mesh, "index.ply"), Error);
}

TEST(Surface, OfAnySizeAndPlaceIsTheSame) {
  formats::TriangleMesh mesh = tests::icosphere(2);
  const Surface unit = surfaceOf(mesh, "ball.ply");
  for (const float scale : {1e-18f, 1e6f}) {
    formats::TriangleMesh scaled = mesh;
    for (auto& p : scaled.positions)
      for (float& x : p) x *= scale;
    const Surface surface = surfaceOf(scaled, "ball.ply");
    ASSERT_EQ(surface.triangleCount(), unit.triangleCount());
    for (std::size_t t = 0; t < unit.triangleCount(); ++t)
      EXPECT_NEAR(surface.areas[t], unit.areas[t], 1e-6 * unit.areas[t]);
  }
}

TEST(Surface, MarksCreasesByAngle) {
  Surface cube = surfaceOf(tests::slabWithHoles(0, 2, 0), "box.ply");
  EXPECT_EQ(markCreases(cube, 89), 4 * 2 + 4 * 2 + 4 * 6);  // 1 × 1 × 3, in halves
  EXPECT_EQ(smoothParts(cube).size(), 6u);
  Surface again = surfaceOf(tests::slabWithHoles(0, 2, 0), "box.ply");
  EXPECT_EQ(markCreases(again, 91), 0);
  EXPECT_EQ(smoothParts(again).size(), 1u);
}

TEST(Chart, KnowsItsTopology) {
  const Chart disk = wholeChart(tests::flatDisk(4));
  EXPECT_TRUE(disk.isDisk());
  EXPECT_EQ(disk.borders[0].size(), 24u);
  const Chart ball = wholeChart(tests::icosphere(1));
  EXPECT_EQ(ball.euler_characteristic, 2);
  EXPECT_FALSE(ball.isPlanar());
  const Chart ring = wholeChart(tests::tube(12, 3, 1, 1));
  EXPECT_EQ(ring.euler_characteristic, 0);
  EXPECT_EQ(ring.borders.size(), 2u);
  EXPECT_TRUE(ring.isPlanar());
  const Chart doughnut = wholeChart(tests::torus(12, 8, 2, 0.5));
  EXPECT_EQ(doughnut.euler_characteristic, 0);
  EXPECT_FALSE(doughnut.isPlanar());
  const Chart five = wholeChart(tests::slabWithHoles(5, 2, 0));
  EXPECT_EQ(five.euler_characteristic, 2 - 2 * 5);
}

TEST(Chart, BordersHaveTheChartToTheLeftLongestFirst) {
  // A square with a square hole, in the plane z = 0 seen from +z.
  formats::TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {0, 3, 0}, {1, 1, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}};
  mesh.triangles = {{0, 1, 5}, {0, 5, 4}, {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
  const Chart chart = wholeChart(mesh);
  ASSERT_EQ(chart.borders.size(), 2u);
  const auto signedArea = [&](const std::vector<std::uint32_t>& loop) {
    double sum = 0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vec3 &a = chart.positions[loop[i]], &b = chart.positions[loop[(i + 1) % loop.size()]];
      sum += (a.x() * b.y() - a.y() * b.x()) / 2;
    }
    return sum;
  };
  // In units of the whole area, which is 8.
  EXPECT_NEAR(signedArea(chart.borders[0]), 9.0 / 8, 1e-12);
  EXPECT_NEAR(signedArea(chart.borders[1]), -1.0 / 8, 1e-12);
}

TEST(Chart, OpensAlongCuts) {
  const formats::TriangleMesh mesh = tests::flatDisk(3);
  Surface surface = surfaceOf(mesh, "disk.ply");
  // From the middle to the border, along the vertices at angle 0.
  std::vector<std::uint32_t> spoke = {0};
  for (std::uint32_t v = 0; v < mesh.vertexCount(); ++v)
    if (mesh.positions[v][1] == 0 && mesh.positions[v][0] > 0) spoke.push_back(v);
  ASSERT_EQ(spoke.size(), 4u);
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (std::size_t i = 0; i + 1 < spoke.size(); ++i) edges.push_back({spoke[i], spoke[i + 1]});
  EXPECT_EQ(cutEdges(surface, edges), 3);
  std::vector<std::uint32_t> all(surface.triangleCount());
  std::iota(all.begin(), all.end(), 0u);
  const Chart chart = chartOf(surface, all);
  EXPECT_TRUE(chart.isDisk());
  EXPECT_EQ(chart.vertexCount(), mesh.vertexCount() + 3);  // all of the spoke but the middle twice
  EXPECT_EQ(chart.borders[0].size(), 18u + 2 * 3);
}

TEST(Chart, PartsThatMeetAtAPointHaveAVertexEach) {
  formats::TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 4}};
  const Surface surface = surfaceOf(mesh, "bow.ply");
  const std::vector<std::uint32_t> both = {0, 1};
  EXPECT_EQ(chartOf(surface, both).vertexCount(), 6u);
  EXPECT_EQ(connectedParts(surface, std::vector<std::int32_t>{7, 7}).size(), 2u);
}

}  // namespace
}  // namespace bakelight::atlas
