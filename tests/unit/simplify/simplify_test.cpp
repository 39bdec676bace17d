#include "tools/simplify/simplify.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "formats/error.h"
#include "tests/support/rippled_ball.h"
#include "tests/support/shapes.h"
#include "tools/simplify/refine.h"

namespace bakelight::simplify {
namespace {

using formats::Float3;
using formats::TriangleMesh;
using transport::float3;
using transport::vec3;

SimplifyResult simplifyTo(const TriangleMesh& mesh, int triangles) {
  SimplifyOptions options;
  options.triangles = triangles;
  return simplify(mesh, options, "test");
}

// n × n squares over [0, 1]², two triangles each; `height` gives z.
template <class Height>
TriangleMesh grid(int n, Height height) {
  TriangleMesh mesh;
  for (int y = 0; y <= n; ++y) {
    for (int x = 0; x <= n; ++x) {
      const double u = static_cast<double>(x) / n, v = static_cast<double>(y) / n;
      mesh.positions.push_back(float3({u, v, height(u, v)}));
    }
  }
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const auto a = static_cast<std::uint32_t>(y * (n + 1) + x), b = a + 1;
      const std::uint32_t c = a + static_cast<std::uint32_t>(n) + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  }
  return mesh;
}

// The unit cube's faces as separate n × n grids (the weld joins them).
TriangleMesh cube(int n) {
  const TriangleMesh face = grid(n, [](double, double) { return 1.0; });
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool far : {false, true}) {
      TriangleMesh turned = face;
      for (Float3& p : turned.positions) {
        const float u = far ? p[0] : p[1], v = far ? p[1] : p[0];
        Float3 q{};
        q[static_cast<std::size_t>(axis)] = far ? 1.0f : 0.0f;
        q[static_cast<std::size_t>((axis + 1) % 3)] = u;
        q[static_cast<std::size_t>((axis + 2) % 3)] = v;
        p = q;
      }
      tests::append(mesh, turned);
    }
  }
  return mesh;
}

void expectSound(const SimplifyResult& result) {
  const TriangleMesh& mesh = result.mesh;
  ASSERT_FALSE(mesh.triangles.empty());
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  for (const Float3& p : mesh.positions) {
    for (const float x : p) ASSERT_TRUE(std::isfinite(x));
  }
  for (const Float3& n : mesh.normals) ASSERT_NEAR(vec3(n).norm(), 1, 1e-5);
  for (const auto& t : mesh.triangles) {
    for (const std::uint32_t i : t) ASSERT_LT(i, mesh.vertexCount());
  }
}

TEST(Simplify, FineSphereStaysASphere) {
  const SimplifyResult result = simplifyTo(tests::icosphere(5), 2000);  // from 20,480
  expectSound(result);
  EXPECT_EQ(result.report.triangles_out, 2000);
  EXPECT_EQ(result.report.topology_out.euler_characteristic, 2);
  EXPECT_TRUE(result.report.topology_out.closed());
  // The centre of an inscribed triangle of side s lies s²/6 below the sphere; s² = 4A/√3. The fit puts
  // vertices outside by about as much as it takes from the centres; sides vary by a factor of √2.
  const double s2 = 4 * (4 * M_PI / 2000) / std::sqrt(3.0);
  for (const Float3& p : result.mesh.positions) EXPECT_NEAR(vec3(p).norm(), 1, s2 / 3);
  EXPECT_LT(result.report.deviation.hausdorff * std::sqrt(12.0), s2 / 2);
  EXPECT_NEAR(result.report.volume_out / result.report.volume_in, 1, 1e-3);
  EXPECT_GT(result.report.angles_out.mean_min_angle_deg, 45);
  EXPECT_GT(result.report.angles_out.worst_min_angle_deg, 12);
}

TEST(Simplify, NoTriangleOfTheSphereTurnsOver) {
  const SimplifyResult result = simplifyTo(tests::icosphere(5), 1000);
  const WorkingMesh mesh = workingMesh(result.mesh);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 center = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
    EXPECT_GT(mesh.areaVector(t).normalized().dot(center.normalized()), 0.9) << "triangle " << t;
  }
}

TEST(Simplify, SameBytesWithOneThreadAndWithMany) {
  const TriangleMesh input = tests::icosphere(4);
  const auto withThreads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return simplifyTo(input, 700);
  };
  const SimplifyResult one = withThreads(1), many = withThreads(8);
  EXPECT_EQ(one.mesh.positions, many.mesh.positions);
  EXPECT_EQ(one.mesh.normals, many.mesh.normals);
  EXPECT_EQ(one.mesh.triangles, many.mesh.triangles);
  EXPECT_EQ(one.report.deviation.mean, many.report.deviation.mean);
}

// Large enough for every step to be shared out, with ripples, folds at the poles and a hole.
TEST(Simplify, ManyTrianglesGiveTheSameBytesWithOneThreadAndWithMany) {
  TriangleMesh input = tests::rippledBall(30'000);
  input.triangles.resize(input.triangles.size() - 100);
  const auto withThreads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return simplifyTo(input, 4000);
  };
  const SimplifyResult one = withThreads(1), many = withThreads(7);
  EXPECT_EQ(one.report.triangles_out, 4000);
  EXPECT_EQ(one.mesh.positions, many.mesh.positions);
  EXPECT_EQ(one.mesh.triangles, many.mesh.triangles);
  EXPECT_EQ(one.report.flips, many.report.flips);
  EXPECT_EQ(one.report.deviation.hausdorff, many.report.deviation.hausdorff);
}

TEST(Simplify, CubeKeepsItsCornersAndFlatFaces) {
  const SimplifyResult result = simplifyTo(cube(16), 300);  // from 3,072
  expectSound(result);
  EXPECT_LE(result.report.triangles_out, 300);
  EXPECT_EQ(result.report.constraints, "full");
  EXPECT_NEAR(result.report.volume_out, 1, 1e-6);
  EXPECT_NEAR(result.report.area_out, 6, 1e-6);
  const std::set<Float3> positions(result.mesh.positions.begin(), result.mesh.positions.end());
  for (int i = 0; i < 8; ++i) {
    const Float3 corner = {static_cast<float>(i & 1), static_cast<float>(i >> 1 & 1),
                           static_cast<float>(i >> 2)};
    EXPECT_TRUE(positions.contains(corner)) << "corner " << i;
  }
  for (const Float3& n : result.mesh.normals) EXPECT_NEAR(vec3(n).cwiseAbs().maxCoeff(), 1, 1e-6);
}

TEST(Simplify, OpenGridKeepsItsBorder) {
  const SimplifyResult result =
      simplifyTo(grid(40, [](double u, double v) { return 0.1 * std::sin(5 * u) * std::cos(4 * v); }), 600);
  expectSound(result);
  EXPECT_EQ(result.report.topology_out.euler_characteristic, 1);  // a disk
  EXPECT_GT(result.report.topology_out.boundary_edges, 4);
  EXPECT_LT(result.report.deviation.hausdorff, 0.005);
  const std::set<Float3> positions(result.mesh.positions.begin(), result.mesh.positions.end());
  std::set<std::pair<float, float>> corners;
  for (const Float3& p : positions) corners.insert({p[0], p[1]});
  for (const auto& corner : {std::pair(0.f, 0.f), {1.f, 0.f}, {0.f, 1.f}, {1.f, 1.f}}) {
    EXPECT_TRUE(corners.contains(corner));
  }
}

TEST(Simplify, DoesNotDecimateWhatIsSmallEnough) {
  const TriangleMesh input = tests::icosphere(2);
  const SimplifyResult result = simplifyTo(input, 20000);
  EXPECT_EQ(result.mesh.triangles, input.triangles);
  ASSERT_EQ(result.report.left_out.size(), 1u);
  EXPECT_LT(result.report.deviation.hausdorff, 1e-12);
  for (std::size_t v = 0; v < input.vertexCount(); ++v) {
    EXPECT_NEAR((vec3(result.mesh.positions[v]) - vec3(input.positions[v])).norm(), 0, 1e-6);
  }
}

// A hole closed by a fan of needles: halves of the shorter sides alone would never become short.
// As many triangles as asked for, and the same surface.
TEST(Simplify, RefinesACoarseMeshWhereItIsAskedTo) {
  const TriangleMesh coarse = tests::icosphere(1);
  SimplifyOptions options;
  options.triangles = 2000;
  EXPECT_EQ(simplify(coarse, options, "test").mesh.triangleCount(), coarse.triangleCount());
  options.refine = true;
  const SimplifyResult refined = simplify(coarse, options, "test");
  EXPECT_NEAR(static_cast<double>(refined.mesh.triangleCount()), 2000, 20);
  EXPECT_LT(refined.report.deviation.hausdorff, 0.01);
  EXPECT_GT(refined.report.angles_out.mean_min_angle_deg, 40);
}

TEST(Simplify, LeavesSmallPartsOutAndSaysSo) {
  TriangleMesh mesh = tests::icosphere(3);
  tests::append(mesh, tests::icosphere(1, 0.03));  // 1/1100 of the area, inside
  SimplifyOptions options;
  EXPECT_EQ(simplify(mesh, options, "test").mesh.triangleCount(), mesh.triangleCount());
  options.least_part = 1e-4;
  EXPECT_EQ(simplify(mesh, options, "test").mesh.triangleCount(), mesh.triangleCount());
  options.least_part = 0.002;
  const SimplifyResult result = simplify(mesh, options, "test");
  EXPECT_EQ(result.mesh.triangleCount(), tests::icosphere(3).triangleCount());
  EXPECT_EQ(result.report.small_parts.parts, 1U);
  ASSERT_FALSE(result.report.warnings.empty());
  EXPECT_THAT(result.report.warnings.back(), testing::HasSubstr("80 triangles"));
  // Never all of it.
  options.least_part = 1;
  EXPECT_EQ(simplify(tests::icosphere(2), options, "test").mesh.triangleCount(),
            tests::icosphere(2).triangleCount());
}

TEST(Refine, LongTrianglesBecomeShortInFewSplits) {
  WorkingMesh fan;
  constexpr std::uint32_t kSides = 60;
  fan.positions.push_back({20, 3, 0});
  for (std::uint32_t k = 0; k < kSides; ++k) {
    const double angle = 2 * M_PI * k / kSides;
    fan.positions.push_back({35 * std::cos(angle), 35 * std::sin(angle), 0});
    fan.triangles.push_back({0, 1 + k, 1 + (k + 1) % kSides});
  }
  CornerMesh mesh(fan);
  const double area_before = area(fan);
  const std::int64_t splits = splitLongEdges(mesh, 10, 20'000);
  EXPECT_GT(splits, kSides);
  EXPECT_LT(splits, 20 * kSides);
  for (Side s = 0; s < mesh.opposite.size(); ++s) EXPECT_LE(mesh.length(s), 10);
  EXPECT_NEAR(area({mesh.positions, mesh.triangles}), area_before, 1e-9 * area_before);
}

// ---- stiff and extreme
// ---------------------------------------------------------------------------------------------

TEST(SimplifyStiff, ScalesGiveTheSameMesh) {
  const SimplifyResult reference = simplifyTo(tests::icosphere(4), 500);
  for (const double scale :
       {std::ldexp(1.0, -20), std::ldexp(1.0, 20)}) {  // about 1e-6 and 1e6, exact in floats
    const SimplifyResult result = simplifyTo(tests::icosphere(4, scale), 500);
    expectSound(result);
    EXPECT_EQ(result.mesh.triangles, reference.mesh.triangles);
    EXPECT_NEAR(result.report.volume_out / reference.report.volume_out, scale * scale * scale,
                1e-6 * scale * scale * scale);
  }
}

TEST(SimplifyStiff, FarFromTheOrigin) {
  // Floats are 1/16 apart there; 500 triangles leave a sphere of radius 100 by about s²/(6·100) = 1.
  const Vec3 center(1e6, 1e6, -1e6);
  const SimplifyResult result = simplifyTo(tests::icosphere(4, 100, center), 500);
  expectSound(result);
  EXPECT_EQ(result.report.triangles_out, 500);
  EXPECT_EQ(result.report.topology_out.euler_characteristic, 2);
  for (const Float3& p : result.mesh.positions) EXPECT_NEAR((vec3(p) - center).norm(), 100, 2);
}

TEST(SimplifyStiff, NeedlesDuplicatesAndStrayVertices) {
  TriangleMesh mesh = tests::icosphere(4);
  for (std::uint32_t t = 0; t < 200; ++t) {
    const formats::Triangle triangle = mesh.triangles[t];
    mesh.triangles.push_back({triangle[1], triangle[0], triangle[2]});
    mesh.triangles.push_back({triangle[0], triangle[0], triangle[1]});
    const auto base = static_cast<std::uint32_t>(mesh.vertexCount());
    const auto x = static_cast<float>(t);
    mesh.positions.insert(mesh.positions.end(), {{x, 3, 0}, {x, 4, 0}, {x, 3.5f, 1e-6f}, {x, 9, 9}});
    mesh.triangles.push_back({base, base + 1, base + 2});  // a needle of aspect 1e6 on its own
  }
  mesh.normals.clear();
  const SimplifyResult result = simplifyTo(mesh, 1000);
  expectSound(result);
  EXPECT_EQ(result.report.repairs.reversed_triangles, 200);
  EXPECT_EQ(result.report.repairs.repeated_index_triangles, 200);
  EXPECT_EQ(result.report.repairs.zero_area_triangles, 200);
  EXPECT_EQ(result.report.repairs.isolated_vertices, 200);
  EXPECT_EQ(result.report.topology_in.components, 1);
  EXPECT_EQ(result.report.triangles_out, 1000);
}

TEST(SimplifyStiff, ManyComponents) {
  TriangleMesh mesh;
  for (int i = 0; i < 64; ++i) tests::append(mesh, tests::icosphere(1, 1, {3.0 * (i % 8), 3.0 * (i / 8), 0}));
  const SimplifyResult result = simplifyTo(mesh, 2000);
  expectSound(result);
  EXPECT_EQ(result.report.topology_out.components, 64);
  EXPECT_TRUE(result.report.topology_out.closed());
  EXPECT_EQ(result.report.triangles_out, 2000);
}

TEST(SimplifyStiff, TargetThatTopologyForbidsIsSaid) {
  TriangleMesh mesh;
  for (int i = 0; i < 3; ++i) tests::append(mesh, tests::icosphere(1, 1, {3.0 * i, 0, 0}));
  const SimplifyResult result = simplifyTo(mesh, 4);
  expectSound(result);
  EXPECT_GE(result.report.triangles_out, 12);
  EXPECT_FALSE(result.report.warnings.empty());
}

TEST(SimplifyStiff, SphereToATetrahedron) {
  const SimplifyResult result = simplifyTo(tests::icosphere(3), 4);
  expectSound(result);
  EXPECT_EQ(result.report.triangles_out, 4);
  EXPECT_GT(result.report.volume_out, 0);
}

TEST(SimplifyStiff, OneTriangle) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  const SimplifyResult result = simplifyTo(mesh, 4);
  expectSound(result);
  EXPECT_EQ(result.report.triangles_out, 1);
}

TEST(SimplifyErrors, SayWhatIsWrongAndWhere) {
  const auto problemOf = [](const TriangleMesh& mesh) {
    try {
      simplifyTo(mesh, 100);
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), ExitStatus::kBadInput);
      return error.place().element + ": " + error.problem();
    }
    return std::string("no error");
  };
  TriangleMesh mesh;
  EXPECT_EQ(problemOf(mesh), ": the mesh has no triangle");
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  mesh.triangles = {{0, 1, 2}};
  EXPECT_EQ(problemOf(mesh), ": no triangle of the mesh has an area");
  mesh.triangles = {{0, 1, 3}};
  EXPECT_EQ(problemOf(mesh), "face 0: vertex index 3 is out of range");
  mesh.triangles = {{0, 1, 2}};
  mesh.positions[2][1] = NAN;
  EXPECT_EQ(problemOf(mesh), "vertex 2: a coordinate is not finite");
}

}  // namespace
}  // namespace bakelight::simplify
