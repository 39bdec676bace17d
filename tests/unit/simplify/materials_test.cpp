#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "formats/materials.h"
#include "surface/repair.h"
#include "tests/support/shapes.h"
#include "tools/simplify/double_sided.h"
#include "tools/simplify/normals.h"
#include "tools/simplify/simplify.h"
#include "tools/simplify/surface_words.h"

namespace bakelight::simplify {
namespace {

using formats::TriangleMesh;
using transport::float3;
using transport::vec3;

Vec3 centroid(const TriangleMesh& mesh, std::size_t t) {
  Vec3 sum = Vec3::Zero();
  for (const std::uint32_t v : mesh.triangles[t]) sum += vec3(mesh.positions[v]) / 3;
  return sum;
}

// A material for each triangle, by its centroid.
template <class MaterialAt>
void paint(TriangleMesh& mesh, int materials, const MaterialAt& material_at) {
  for (int m = 0; m < materials; ++m) mesh.material_names.push_back("material " + std::to_string(m));
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t)
    mesh.triangle_materials.push_back(static_cast<std::uint32_t>(material_at(centroid(mesh, t))));
}

// n × n squares over [0, 1]², facing +Z.
TriangleMesh square(int n) {
  TriangleMesh mesh;
  const auto row = static_cast<std::uint32_t>(n + 1);
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x)
      mesh.positions.push_back(
          {static_cast<float>(x) / static_cast<float>(n), static_cast<float>(y) / static_cast<float>(n), 0});
  for (std::uint32_t y = 0; y + 1 < row; ++y)
    for (std::uint32_t x = 0; x + 1 < row; ++x) {
      const std::uint32_t a = y * row + x;
      mesh.triangles.push_back({a, a + 1, a + row + 1});
      mesh.triangles.push_back({a, a + row + 1, a + row});
    }
  return mesh;
}

std::vector<double> areas(const TriangleMesh& mesh) {
  std::vector<double> result(mesh.material_names.size());
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3 origin = vec3(mesh.positions[a]);
    result[mesh.triangle_materials[t]] +=
        (vec3(mesh.positions[b]) - origin).cross(vec3(mesh.positions[c]) - origin).norm() / 2;
  }
  return result;
}

// The edges between two materials, as points on them.
std::vector<Vec3> border(const TriangleMesh& mesh) {
  using Place = formats::Float3;
  std::map<std::pair<Place, Place>, std::set<std::uint32_t>> materials;
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const Place a = mesh.positions[mesh.triangles[t][k]],
                  b = mesh.positions[mesh.triangles[t][(k + 1) % 3]];
      materials[std::minmax(a, b)].insert(mesh.triangle_materials[t]);
    }
  std::vector<Vec3> points;
  for (const auto& [edge, sides] : materials)
    for (int i = 0; sides.size() > 1 && i <= 8; ++i)
      points.push_back(vec3(edge.first) + i / 8.0 * (vec3(edge.second) - vec3(edge.first)));
  return points;
}

double hausdorff(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  const auto oneWay = [](const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
    double farthest = 0;
    for (const Vec3& p : from) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const Vec3& q : to) nearest = std::min(nearest, (p - q).norm());
      farthest = std::max(farthest, nearest);
    }
    return farthest;
  };
  return std::max(oneWay(a, b), oneWay(b, a));
}

void expectNoSharedVertices(const TriangleMesh& mesh) {
  std::map<std::uint32_t, std::uint32_t> material_of;
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t)
    for (const std::uint32_t v : mesh.triangles[t])
      ASSERT_EQ(material_of.try_emplace(v, mesh.triangle_materials[t]).first->second,
                mesh.triangle_materials[t]);
}

SimplifyResult simplifyTo(const TriangleMesh& mesh, int triangles) {
  SimplifyOptions options;
  options.triangles = triangles;
  return simplify(mesh, options, "test");
}

// On a plane nothing but the borders asks for triangles: a disk that follows the input's edges in steps, and
// a quarter whose line ends at the disk.
TEST(Materials, BordersStayWhereTheyAre) {
  TriangleMesh plane = square(64);
  paint(plane, 3, [](const Vec3& p) {
    return (p - Vec3(0.5, 0.5, 0)).norm() < 0.3 ? 1 : p.x() < 0.5 ? 0 : 2;
  });
  const SimplifyResult result = simplifyTo(plane, 700);
  EXPECT_LE(result.mesh.triangleCount(), 700u);
  EXPECT_EQ(result.report.constraints, "full");
  EXPECT_EQ(result.mesh.material_names, plane.material_names);
  EXPECT_EQ(result.report.materials, 3);
  EXPECT_GT(result.report.material_edges, 100);
  expectNoSharedVertices(result.mesh);
  const auto before = areas(plane), after = areas(result.mesh);
  for (std::size_t m = 0; m < 3; ++m) EXPECT_NEAR(after[m] / before[m], 1, 0.01) << m;
  EXPECT_LT(hausdorff(border(result.mesh), border(plane)), 1.5 / 64);
}

TEST(Materials, BordersSurviveWhereCreasesAreGivenUp) {
  TriangleMesh ball = tests::icosphere(4);
  paint(ball, 6, [](const Vec3& p) {
    Eigen::Index axis = 0;
    p.cwiseAbs().maxCoeff(&axis);
    return static_cast<int>(2 * axis) + (p[axis] < 0 ? 1 : 0);
  });
  for (const int triangles : {1000, 300}) {
    const SimplifyResult result = simplifyTo(ball, triangles);
    EXPECT_EQ(result.report.materials, 6);
    expectNoSharedVertices(result.mesh);
    const auto before = areas(ball), after = areas(result.mesh);
    // A coarse ball has less area as a whole.
    const double shrink = tests::surfaceArea(result.mesh) / tests::surfaceArea(ball);
    for (std::size_t m = 0; m < 6; ++m)
      EXPECT_NEAR(after[m] / before[m] / shrink, 1, triangles == 1000 ? 0.01 : 0.04) << m;
    EXPECT_LT(hausdorff(border(result.mesh), border(ball)), triangles == 1000 ? 0.06 : 0.12);
  }
}

// Small enough to be taken for noise if it were a crease.
TEST(Materials, ASmallSpotStays) {
  TriangleMesh plane = square(40);
  paint(plane, 2, [](const Vec3& p) { return (p - Vec3(0.3, 0.6, 0)).norm() < 0.03 ? 1 : 0; });
  ASSERT_GT(formats::trianglesOfMaterials(plane)[1], 0u);
  const SimplifyResult result = simplifyTo(plane, 100);
  EXPECT_EQ(result.report.materials, 2);
  EXPECT_NEAR(areas(result.mesh)[1] / areas(plane)[1], 1, 0.25);
}

TEST(Materials, ATargetThatBordersForbidIsTold) {
  TriangleMesh plane = square(8);
  int next = 0;
  paint(plane, 128, [&](const Vec3&) { return next++; });
  const SimplifyResult result = simplifyTo(plane, 20);
  EXPECT_EQ(result.report.materials, 128);
  ASSERT_EQ(result.report.warnings.size(), 1u);
  EXPECT_NE(result.report.warnings[0].find("borders between materials"), std::string::npos);
}

TEST(Materials, SplittingLongEdgesKeepsThem) {
  TriangleMesh plane = square(1);
  paint(plane, 2, [](const Vec3& p) { return p.x() > p.y() ? 1 : 0; });
  // A far part with many triangles makes the plane's edges long beside those asked for.
  TriangleMesh ball = tests::icosphere(3, 0.4, Vec3(3, 0, 0));
  ball.normals.clear();
  tests::append(plane, ball);
  plane.triangle_materials.resize(plane.triangleCount(), 1);
  const SimplifyResult result = simplifyTo(plane, 1000);
  EXPECT_GT(result.report.splits, 0);
  EXPECT_NEAR(areas(result.mesh)[0], 0.5, 1e-6);
}

TEST(Materials, RepairTakesEachTrianglesAlong) {
  WorkingMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 0, 0}, {0, 0, 0}};
  mesh.triangles = {{0, 5, 1}, {0, 1, 2}, {1, 2, 0}, {1, 3, 2}, {1, 4, 3}};
  mesh.materials = {9, 1, 8, 3, 4};
  const RepairCounts counts = repair(mesh, 0);
  EXPECT_EQ(counts.repeated_index_triangles, 1);
  EXPECT_EQ(counts.duplicate_triangles, 1);
  EXPECT_EQ(mesh.materials, (std::vector<std::uint32_t>{1, 3, 4}));
}

// Vertex 4 lies on the side that the material below shares with a cap of the material above.
TEST(Materials, AFlatTriangleTakesItsNeighborsMaterial) {
  WorkingMesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {1, 1, 0}, {1, -1, 0}, {1, 0, 0}};
  mesh.triangles = {{0, 4, 2}, {4, 1, 2}, {0, 1, 4}, {0, 3, 1}};
  mesh.materials = {0, 0, 0, 1};
  const RepairCounts counts = repair(mesh, 0);
  EXPECT_EQ(counts.zero_area_triangles, 1);
  ASSERT_EQ(mesh.triangles.size(), 4u);
  ASSERT_EQ(mesh.materials.size(), 4u);
  for (std::size_t t = 0; t < 4; ++t) {
    const double y = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)).y();
    EXPECT_GT(mesh.areaVector(t).norm(), 0.5);
    EXPECT_EQ(mesh.materials[t], y > 0 ? 0u : 1u);
  }
}

TEST(Materials, AcrossASmoothBorderNormalsAreEqual) {
  TriangleMesh ball = tests::icosphere(3);
  paint(ball, 2, [](const Vec3& p) { return p.y() > 0 ? 1 : 0; });
  const ShadedMesh shaded = withNormals(workingMesh(ball), 60, 0);
  EXPECT_EQ(shaded.split_vertices, 0);
  EXPECT_GT(shaded.material_vertices, 20);
  EXPECT_EQ(shaded.mesh.vertexCount(),
            ball.vertexCount() + static_cast<std::size_t>(shaded.material_vertices));
  expectNoSharedVertices(shaded.mesh);
  std::map<formats::Float3, formats::Float3> normal_at;
  for (std::size_t v = 0; v < shaded.mesh.vertexCount(); ++v)
    EXPECT_EQ(normal_at.try_emplace(shaded.mesh.positions[v], shaded.mesh.normals[v]).first->second,
              shaded.mesh.normals[v]);
}

TEST(Materials, OneMaterialChangesNothingButItsName) {
  TriangleMesh ball = tests::icosphere(4);
  const TriangleMesh plain = simplifyTo(ball, 500).mesh;
  paint(ball, 1, [](const Vec3&) { return 0; });
  const TriangleMesh named = simplifyTo(ball, 500).mesh;
  EXPECT_EQ(named.positions, plain.positions);
  EXPECT_EQ(named.triangles, plain.triangles);
  EXPECT_EQ(named.triangle_materials, std::vector<std::uint32_t>(named.triangleCount(), 0));
  EXPECT_TRUE(plain.triangle_materials.empty());
}

TEST(Materials, BacksHaveThoseOfTheirFronts) {
  TriangleMesh plane = square(4);
  plane.normals.assign(plane.vertexCount(), {0, 0, 1});
  paint(plane, 2, [](const Vec3& p) { return p.x() > 0.5 ? 1 : 0; });
  const std::vector<std::uint32_t> fronts = plane.triangle_materials;
  ASSERT_EQ(addBacks(plane), fronts.size());
  formats::requireMaterials(plane);
  for (std::size_t t = 0; t < fronts.size(); ++t)
    EXPECT_EQ(plane.triangle_materials[fronts.size() + t], fronts[t]);
}

TEST(Materials, SameBytesWithAnyNumberOfThreads) {
  TriangleMesh ball = tests::icosphere(4);
  paint(ball, 3, [](const Vec3& p) { return p.y() > 0.2 ? 0 : p.x() > 0 ? 1 : 2; });
  const TriangleMesh many = simplifyTo(ball, 800).mesh;
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const TriangleMesh single = simplifyTo(ball, 800).mesh;
  EXPECT_EQ(many.positions, single.positions);
  EXPECT_EQ(many.triangles, single.triangles);
  EXPECT_EQ(many.triangle_materials, single.triangle_materials);
}

}  // namespace
}  // namespace bakelight::simplify
