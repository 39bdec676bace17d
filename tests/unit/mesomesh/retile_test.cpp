#include "tools/mesomesh/retile/retile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "bodies.h"
#include "formats/error.h"
#include "transport/mesh_topology.h"
#include "transport/surface_query.h"

namespace bakelight::mesomesh {
namespace {

using formats::TriangleMesh;
using tests::vec3;
using transport::Vec3;

RetiledMesh retiled(const TriangleMesh& mesh, std::int64_t vertices) {
  RetileOptions options;
  options.vertices = vertices;
  return retile(mesh, options, "mesh.ply");
}

transport::SurfaceMesh surface(const TriangleMesh& mesh) {
  transport::SurfaceMesh result;
  for (const auto& p : mesh.positions) result.positions.push_back(vec3(p));
  result.triangles = mesh.triangles;
  return result;
}

double farthestFrom(const TriangleMesh& original, const TriangleMesh& mesh) {
  const transport::SurfaceQuery query(surface(original));
  double farthest = 0;
  for (const auto& p : mesh.positions) farthest = std::max(farthest, query.closest(vec3(p)).distance);
  return farthest;
}

// Edges by places, with how many triangles they have.
std::map<std::pair<std::uint32_t, std::uint32_t>, int> edgesOf(const TriangleMesh& mesh) {
  const auto place = transport::coincidentVertices(mesh);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++edges[std::minmax(place[t[k]], place[t[(k + 1) % 3]])];
  return edges;
}

struct Body {
  const char* name;
  TriangleMesh mesh;
  std::int64_t vertices;
  double least_quality;
};

std::vector<Body> bodies() {
  std::vector<Body> result = {{"sphere", tests::icosphere(3), 10'000, 0.97},
                              {"torus", tests::torus(24), 10'000, 0.96},
                              {"square", tests::square(), 5'000, 0.97},
                              {"cube", tests::cube(), 20'000, 0.96},
                              {"coarser", tests::icosphere(4), 800, 0.95}};
  TriangleMesh far = tests::icosphere(3, 50);
  for (auto& p : far.positions) p[0] += 1e5F;
  result.push_back({"far", far, 3'000, 0.95});
  TriangleMesh tiny = tests::torus(24);
  for (auto& p : tiny.positions)
    for (float& x : p) x *= 1e-6F;
  result.push_back({"tiny", tiny, 4'000, 0.95});
  return result;
}

TEST(Retile, IsEvenAndLiesOnTheSurfaceWithTheNumberAskedFor) {
  for (const Body& body : bodies()) {
    SCOPED_TRACE(body.name);
    const RetiledMesh result = retiled(body.mesh, body.vertices);
    EXPECT_NEAR(static_cast<double>(result.mesh.vertexCount()) / static_cast<double>(body.vertices), 1,
                kCountTolerance);
    EXPECT_GT(tests::meanQuality(result.mesh), body.least_quality);
    EXPECT_NEAR(result.report.mean_quality, tests::meanQuality(result.mesh), 1e-2);
    float largest = 0;
    for (const auto& p : body.mesh.positions)
      for (const float x : p) largest = std::max(largest, std::abs(x));
    EXPECT_LT(farthestFrom(body.mesh, result.mesh), 1e-6 * largest);
    EXPECT_NEAR(tests::surfaceArea(result.mesh) / tests::surfaceArea(body.mesh), 1, 0.01);
    EXPECT_EQ(result.report.folded_triangles, 0);
    EXPECT_LT(result.report.largest_deviation, 0.01);
    EXPECT_TRUE(result.report.warnings.empty()) << result.report.warnings.front();
    for (std::size_t v = 0; v < result.mesh.vertexCount(); ++v)
      ASSERT_NEAR(vec3(result.mesh.normals[v]).norm(), 1, 1e-5);
  }
}

TEST(Retile, ClosedSurfacesStayClosedAndOfTheirGenus) {
  for (const auto& [mesh, euler] :
       {std::pair(tests::icosphere(3), 2), std::pair(tests::torus(), 0), std::pair(tests::cube(), 2)}) {
    const RetiledMesh result = retiled(mesh, 8'000);
    const auto edges = edgesOf(result.mesh);
    for (const auto& [edge, count] : edges) ASSERT_EQ(count, 2);
    const auto place = transport::coincidentVertices(result.mesh);
    const std::set<std::uint32_t> places(place.begin(), place.end());
    EXPECT_EQ(static_cast<long>(places.size()) - static_cast<long>(edges.size()) +
                  static_cast<long>(result.mesh.triangleCount()),
              euler);
  }
}

TEST(Retile, NormalsAreThoseOfTheOriginalSurface) {
  const RetiledMesh result = retiled(tests::icosphere(4), 10'000);
  for (std::size_t v = 0; v < result.mesh.vertexCount(); ++v)
    ASSERT_GT(vec3(result.mesh.normals[v]).dot(vec3(result.mesh.positions[v]).normalized()), 0.9995);
}

// The cube's edges stay straight, its corners stay, each side has its own vertices there.
TEST(Retile, CreasesStayAndHaveVerticesOnBothSides) {
  const RetiledMesh result = retiled(tests::cube(), 20'000);
  EXPECT_EQ(result.report.crease_edges, 12);
  EXPECT_EQ(result.report.corners, 8);
  std::map<formats::Float3, std::set<int>> normals_at;
  for (std::size_t v = 0; v < result.mesh.vertexCount(); ++v) {
    const Vec3 p = vec3(result.mesh.positions[v]), n = vec3(result.mesh.normals[v]);
    int axis = 0;
    ASSERT_NEAR(n.cwiseAbs().maxCoeff(&axis), 1, 1e-6);
    ASSERT_NEAR(p.dot(n), 0.5, 1e-6);  // on the side that it faces as
    normals_at[result.mesh.positions[v]].insert(n[axis] > 0 ? axis : axis + 3);
  }
  int corners = 0, on_edges = 0;
  for (const auto& [p, normals] : normals_at) {
    const auto on_sides = std::count_if(p.begin(), p.end(), [](float x) { return std::abs(x) == 0.5F; });
    ASSERT_EQ(static_cast<std::size_t>(on_sides), normals.size());
    corners += on_sides == 3, on_edges += on_sides == 2;
  }
  EXPECT_EQ(corners, 8);
  // Twelve edges of length 1 at the mean edge length.
  EXPECT_NEAR(on_edges * result.report.edge_length / 12, 1, 0.3);
  for (const auto& triangle : result.mesh.triangles) {
    const Vec3 n = vec3(result.mesh.normals[triangle[0]]);
    ASSERT_EQ(n, vec3(result.mesh.normals[triangle[1]]));
    ASSERT_EQ(n, vec3(result.mesh.normals[triangle[2]]));
  }
}

TEST(Retile, BordersStay) {
  const RetiledMesh result = retiled(tests::square(), 4'000);
  double length = 0;
  for (const auto& [edge, count] : edgesOf(result.mesh)) {
    if (count == 2) continue;
    const Vec3 a = vec3(result.mesh.positions[edge.first]), b = vec3(result.mesh.positions[edge.second]);
    length += (b - a).norm();
    ASSERT_TRUE(std::any_of(a.data(), a.data() + 2, [](double x) { return x == 0 || x == 1; }));
  }
  EXPECT_NEAR(length, 4, 1e-5);
  EXPECT_NEAR(tests::surfaceArea(result.mesh), 1, 1e-5);
}

TEST(Retile, BordersBetweenMaterialsStay) {
  TriangleMesh mesh =
      tests::sheet(8, 8, [](double u, double v) { return Vec3(u, v, 0.2 * std::sin(3 * u)); });
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t)
    mesh.triangle_materials.push_back(t / 2 % 8 < 4 ? 2 : 0);
  mesh.material_names = {"right", "unused", "left"};
  const RetiledMesh result = retiled(mesh, 6'000);
  ASSERT_EQ(result.materials.size(), result.mesh.vertexCount());
  EXPECT_EQ(result.mesh.material_names, mesh.material_names);
  EXPECT_EQ(result.report.material_edges, 8);
  int left = 0, right = 0;
  for (std::size_t t = 0; t < result.mesh.triangleCount(); ++t)
    for (const std::uint32_t v : result.mesh.triangles[t]) {
      ASSERT_EQ(result.materials[v], result.mesh.triangle_materials[t]);
      const float x = result.mesh.positions[v][0];
      const bool is_left = result.materials[v] == 2;
      ASSERT_TRUE(is_left ? x <= 0.5F + 1e-6F : x >= 0.5F - 1e-6F);
      if (std::abs(x - 0.5F) < 1e-6F) ++(is_left ? left : right);
    }
  EXPECT_GT(left, 50);
  EXPECT_GT(right, 50);
}

TEST(Retile, SheetsOfTwoSidesKeepBoth) {
  TriangleMesh mesh = tests::square();
  const auto count = mesh.triangleCount();
  for (std::size_t t = 0; t < count; ++t)
    mesh.triangles.push_back({mesh.triangles[t][0], mesh.triangles[t][2], mesh.triangles[t][1]});
  const RetiledMesh result = retiled(mesh, 6'000);
  EXPECT_NEAR(static_cast<double>(result.mesh.vertexCount()), 6'000, 300);
  EXPECT_NEAR(tests::surfaceArea(result.mesh), 2, 1e-4);
  const auto up = std::count_if(result.mesh.normals.begin(), result.mesh.normals.end(),
                                [](const auto& n) { return n[2] > 0.99F; });
  EXPECT_EQ(2 * static_cast<std::size_t>(up), result.mesh.vertexCount());
}

TEST(Retile, AnyNumberOfThreadsGivesTheSameBytes) {
  const TriangleMesh mesh = tests::torus(24);
  const RetiledMesh many = retiled(mesh, 30'000);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const RetiledMesh single = retiled(mesh, 30'000);
  EXPECT_EQ(many.report.subdivisions, 1);
  EXPECT_EQ(many.mesh.positions, single.mesh.positions);
  EXPECT_EQ(many.mesh.normals, single.mesh.normals);
  EXPECT_EQ(many.mesh.triangles, single.mesh.triangles);
  EXPECT_EQ(many.report.mean_quality, single.report.mean_quality);
  EXPECT_EQ(many.report.mean_deviation, single.report.mean_deviation);
}

// ---- stiff cases

std::string errorOf(const TriangleMesh& mesh, std::int64_t vertices) {
  try {
    retiled(mesh, vertices);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

using testing::AllOf;
using testing::HasSubstr;

TEST(RetileStiff, WhatCannotBeIsAnErrorThatSaysWhy) {
  EXPECT_THAT(errorOf({}, 1000), AllOf(HasSubstr("mesh.ply"), HasSubstr("no triangle")));
  TriangleMesh mesh = tests::square();
  mesh.triangles[3][1] = 99;
  EXPECT_THAT(errorOf(mesh, 1000), AllOf(HasSubstr("face 3"), HasSubstr("99")));
  mesh = tests::square();
  mesh.positions[2][1] = std::nanf("");
  EXPECT_THAT(errorOf(mesh, 1000), AllOf(HasSubstr("vertex 2"), HasSubstr("not finite")));
  mesh = tests::sheet(4, 4, [](double u, double) { return Vec3(u, 0, 0); });
  EXPECT_THAT(errorOf(mesh, 1000), HasSubstr("no triangle of the mesh has an area"));
  mesh = tests::square();
  for (auto& p : mesh.positions) p[0] += 65536;
  EXPECT_THAT(errorOf(mesh, 100'000), AllOf(HasSubstr("closer than 0.0078"), HasSubstr("origin")));
  EXPECT_THAT(errorOf(tests::cube(), 10),
              AllOf(HasSubstr("10 vertices cannot be had"), HasSubstr("corners")));
}

TEST(RetileStiff, OneTriangle) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  const RetiledMesh result = retiled(mesh, 5'000);
  EXPECT_GT(tests::meanQuality(result.mesh), 0.95);
  EXPECT_NEAR(tests::surfaceArea(result.mesh), 0.5, 1e-6);
}

TEST(RetileStiff, TenThousandComponentsAllStay) {
  TriangleMesh mesh;
  for (int i = 0; i < 10'000; ++i) {
    const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
    const auto x = static_cast<float>(i % 100), y = static_cast<float>(i / 100);
    mesh.positions.insert(mesh.positions.end(), {{x, y, 0}, {x + 0.8F, y, 0}, {x, y + 0.8F, 0}});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  const RetiledMesh result = retiled(mesh, 200'000);
  EXPECT_EQ(result.report.components, 10'000);
  EXPECT_NEAR(tests::surfaceArea(result.mesh), 3200, 1);
  EXPECT_THAT(errorOf(mesh, 20'000), AllOf(HasSubstr("cannot be had"), HasSubstr("10000 components")));
}

TEST(RetileStiff, SheetsCloserThanAnEdgeStayApart) {
  TriangleMesh mesh = tests::square(20);
  TriangleMesh upper = mesh;
  for (auto& p : upper.positions) p[2] += 1e-4F;
  tests::append(mesh, upper);  // facing the same way: only what hangs together tells them apart
  TriangleMesh lower = tests::square(20);
  for (auto& p : lower.positions) p[2] -= 1e-4F;
  lower = tests::insideOut(lower);
  tests::append(mesh, lower);
  const RetiledMesh result = retiled(mesh, 6'000);
  std::map<float, int> count;
  for (const auto& p : result.mesh.positions) ++count[std::round(p[2] * 1e5F)];
  ASSERT_EQ(count.size(), 3U);
  for (const auto& [z, vertices] : count) EXPECT_NEAR(vertices, 2'000, 300);
  for (const auto& [a, b, c] : result.mesh.triangles)
    ASSERT_TRUE(result.mesh.positions[a][2] == result.mesh.positions[b][2] &&
                result.mesh.positions[b][2] == result.mesh.positions[c][2]);
}

TEST(RetileStiff, CreasesOf170Degrees) {
  const double angle = 10 * std::numbers::pi / 180;
  const TriangleMesh mesh = tests::sheet(2, 1, [&](double u, double v) {
    const double x = 2 * u - 1;
    return x < 0 ? Vec3(-x, v, 0) : Vec3(x * std::cos(angle), v, x * std::sin(angle));
  });
  const RetiledMesh result = retiled(mesh, 8'000);
  EXPECT_NEAR(tests::surfaceArea(result.mesh), 2, 1e-4);
  EXPECT_LT(farthestFrom(mesh, result.mesh), 1e-6);
  EXPECT_EQ(result.report.folded_triangles, 0);
  for (std::size_t v = 0; v < result.mesh.vertexCount(); ++v) {
    const Vec3 n = vec3(result.mesh.normals[v]);
    ASSERT_GT(std::max(std::abs(n.z()), 0.0), 0.9);
    ASSERT_NEAR(n.dot(vec3(result.mesh.positions[v])), 0, 1e-6);
  }
}

TEST(RetileStiff, NeedlesBecomeEven) {
  const TriangleMesh mesh = tests::sheet(2'000, 1, [](double u, double v) { return Vec3(u, v, 0); });
  const RetiledMesh result = retiled(mesh, 5'000);
  EXPECT_GT(tests::meanQuality(result.mesh), 0.95);
  EXPECT_NEAR(tests::surfaceArea(result.mesh), 1, 1e-4);
}

TEST(RetileStiff, AMobiusStripIsCutAndTold) {
  const TriangleMesh mesh = tests::mobiusStrip();
  const RetiledMesh result = retiled(mesh, 5'000);
  EXPECT_GT(result.report.repairs.one_sided_cuts, 0);
  EXPECT_THAT(result.report.warnings, testing::Contains(HasSubstr("Möbius")));
  EXPECT_NEAR(tests::surfaceArea(result.mesh) / tests::surfaceArea(mesh), 1, 0.01);
}

TEST(RetileStiff, AnEdgeOfThreeTrianglesIsTold) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0.5F, 1, 0}, {0.5F, -1, 0}, {0.5F, 0, 1}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  const RetiledMesh result = retiled(mesh, 5'000);
  EXPECT_THAT(result.report.warnings, testing::Contains(HasSubstr("more than two triangles")));
  EXPECT_NEAR(tests::surfaceArea(result.mesh), 1.5, 1e-3);
}

}  // namespace
}  // namespace bakelight::mesomesh
