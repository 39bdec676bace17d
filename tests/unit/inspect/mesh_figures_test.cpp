#include "tools/inspect/mesh_figures.h"

#include <cmath>

namespace bakelight::inspect {
namespace {

using formats::TriangleMesh;

// Corner at the origin, three edges of length 1 along the axes.
TriangleMesh tetrahedron() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

// A grid of 4 × 4 unit quads in the plane z = 0, the middle 2 × 2 left out: an annulus.
TriangleMesh annulus() {
  TriangleMesh mesh;
  for (std::uint32_t y = 0; y < 5; ++y)
    for (std::uint32_t x = 0; x < 5; ++x)
      mesh.positions.push_back({static_cast<float>(x), static_cast<float>(y), 0});
  for (std::uint32_t y = 0; y < 4; ++y)
    for (std::uint32_t x = 0; x < 4; ++x) {
      if (x >= 1 && x <= 2 && y >= 1 && y <= 2) continue;
      const std::uint32_t a = 5 * y + x;
      mesh.triangles.insert(mesh.triangles.end(), {{a, a + 1, a + 6}, {a, a + 6, a + 5}});
    }
  return mesh;
}

TEST(MeshFigures, TetrahedronByHand) {
  const MeshFigures figures = measureMesh(tetrahedron());
  EXPECT_EQ(figures.vertices, 4U);
  EXPECT_EQ(figures.triangles, 4U);
  EXPECT_EQ(figures.edges, 6U);
  EXPECT_EQ(figures.euler_characteristic, 2);
  EXPECT_EQ(figures.components, 1U);
  EXPECT_EQ(figures.borders, 0U);
  EXPECT_TRUE(figures.closed);
  EXPECT_EQ(figures.misoriented_edges, 0U);
  EXPECT_DOUBLE_EQ(figures.volume, 1.0 / 6);
  EXPECT_DOUBLE_EQ(figures.diagonal, std::sqrt(3.0));
  EXPECT_DOUBLE_EQ(figures.area, 1.5 + std::sqrt(3.0) / 2);
  EXPECT_DOUBLE_EQ(figures.edge_length.minimum(), 1);
  EXPECT_DOUBLE_EQ(figures.edge_length.maximum(), std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(figures.edge_length.mean(), (3 + 3 * std::sqrt(2.0)) / 6);
  EXPECT_NEAR(figures.smallest_angle_deg.minimum(), 45, 1e-12);
  EXPECT_NEAR(figures.smallest_angle_deg.mean(), (3 * 45 + 60) / 4.0, 1e-12);
  EXPECT_FALSE(figures.has_normals);
}

TEST(MeshFigures, InsideOutHasNegativeVolume) {
  TriangleMesh mesh = tetrahedron();
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  EXPECT_DOUBLE_EQ(measureMesh(mesh).volume, -1.0 / 6);
}

TEST(MeshFigures, OneFlippedTriangleIsMisorientedAlongThreeEdges) {
  TriangleMesh mesh = tetrahedron();
  std::swap(mesh.triangles[0][1], mesh.triangles[0][2]);
  EXPECT_EQ(measureMesh(mesh).misoriented_edges, 3U);
}

TEST(MeshFigures, AnnulusHasTwoBordersAndEulerCharacteristicZero) {
  const MeshFigures figures = measureMesh(annulus());
  EXPECT_EQ(figures.borders, 2U);
  EXPECT_EQ(figures.border_edges, 16U + 8U);
  EXPECT_EQ(figures.euler_characteristic, 0);
  EXPECT_EQ(figures.isolated_vertices, 1U);  // the middle of the hole
  EXPECT_FALSE(figures.closed);
  EXPECT_EQ(figures.volume, 0);
  EXPECT_DOUBLE_EQ(figures.area, 12);
}

TEST(MeshFigures, VerticesSplitAtSeamsCountAsOne) {
  // Each triangle with its own three vertices, as flat-shaded files have it.
  const TriangleMesh shared = tetrahedron();
  TriangleMesh split;
  for (const auto& t : shared.triangles) {
    const auto first = static_cast<std::uint32_t>(split.positions.size());
    for (const std::uint32_t vertex : t) split.positions.push_back(shared.positions[vertex]);
    split.triangles.push_back({first, first + 1, first + 2});
  }
  const MeshFigures figures = measureMesh(split);
  EXPECT_EQ(figures.vertices, 12U);
  EXPECT_EQ(figures.distinct_positions, 4U);
  EXPECT_TRUE(figures.closed);
  EXPECT_EQ(figures.euler_characteristic, 2);
}

TEST(MeshFigures, TwoPartsAreTwoComponents) {
  TriangleMesh mesh = tetrahedron();
  for (const auto& p : tetrahedron().positions) mesh.positions.push_back({p[0] + 5, p[1], p[2]});
  for (const auto& t : tetrahedron().triangles) mesh.triangles.push_back({t[0] + 4, t[1] + 4, t[2] + 4});
  const MeshFigures figures = measureMesh(mesh);
  EXPECT_EQ(figures.components, 2U);
  EXPECT_EQ(figures.euler_characteristic, 4);
  EXPECT_NEAR(figures.volume, 2.0 / 6, 1e-12);
}

TEST(MeshFigures, DegenerateAndNonManifoldAreCounted) {
  TriangleMesh mesh = tetrahedron();
  mesh.triangles.push_back({0, 0, 1});
  mesh.positions.push_back({2, 0, 0});
  mesh.triangles.push_back({0, 1, 4});  // on a line
  mesh.positions.push_back({0, -1, 0});
  mesh.triangles.push_back({0, 1, 5});  // a third triangle at edge 0–1
  const MeshFigures figures = measureMesh(mesh);
  EXPECT_EQ(figures.degenerate_triangles, 2U);
  EXPECT_EQ(figures.non_manifold_edges, 1U);
  EXPECT_EQ(figures.border_edges, 2U);
  EXPECT_FALSE(figures.closed);
}

TEST(MeshFigures, NormalsAreMeasured) {
  TriangleMesh mesh = tetrahedron();
  mesh.normals = {{0, 0, 1}, {0, 1, 0}, {1.5f, 0, 0}, {0, 0, -1}};
  const MeshFigures figures = measureMesh(mesh);
  EXPECT_TRUE(figures.has_normals);
  EXPECT_DOUBLE_EQ(figures.normal_length_error, 0.5);
}

TEST(MeshFigures, AnEmptyMeshHasNoFigures) {
  const MeshFigures figures = measureMesh({});
  EXPECT_EQ(figures.vertices, 0U);
  EXPECT_FALSE(figures.closed);
  EXPECT_EQ(figures.edge_length.finiteCount(), 0U);
}

}  // namespace
}  // namespace bakelight::inspect
