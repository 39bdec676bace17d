// Leaves, cloth, flags: two sheets on one place that face opposite ways.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "formats/materials.h"
#include "surface/repair.h"
#include "tests/support/shapes.h"
#include "tests/unit/transfer/bake.h"
#include "tools/simplify/colors.h"
#include "tools/simplify/simplify.h"
#include "tools/simplify/surface_words.h"
#include "transport/sh.h"

namespace bakelight::simplify {
namespace {

using formats::Float3;
using formats::MeshImport;
using formats::TriangleMesh;
using transport::vec3;

// A leaf of n × n squares over [−1, 1]², bent, its upper sheet of material 0 and its lower one of material 1.
// The sheets share vertices unless `apart`.
TriangleMesh leaf(int n, bool apart) {
  TriangleMesh top;
  const auto row = static_cast<std::uint32_t>(n + 1);
  for (int z = 0; z <= n; ++z)
    for (int x = 0; x <= n; ++x) {
      const float u = 2 * static_cast<float>(x) / static_cast<float>(n) - 1,
                  w = 2 * static_cast<float>(z) / static_cast<float>(n) - 1;
      top.positions.push_back({u, 0.2f * u * u, w});
      top.texcoords.push_back({(u + 1) / 4, (w + 1) / 2});
    }
  for (std::uint32_t z = 0; z + 1 < row; ++z)
    for (std::uint32_t x = 0; x + 1 < row; ++x) {
      const std::uint32_t a = z * row + x;
      top.triangles.push_back({a, a + row, a + 1});
      top.triangles.push_back({a + 1, a + row, a + row + 1});
    }
  TriangleMesh mesh = top;
  const auto vertices = static_cast<std::uint32_t>(top.vertexCount());
  if (apart) {
    mesh.positions.insert(mesh.positions.end(), top.positions.begin(), top.positions.end());
    for (const auto& t : top.texcoords) mesh.texcoords.push_back({t[0] + 0.5f, t[1]});
  }
  // Every other one before its counterpart, so that the first of two is not always the same side.
  mesh.triangles.clear();
  for (std::size_t t = 0; t < top.triangleCount(); ++t) {
    const auto& [a, b, c] = top.triangles[t];
    const std::uint32_t shift = apart ? vertices : 0;
    const formats::Triangle back = {a + shift, c + shift, b + shift};
    for (const bool is_top : {t % 2 == 0, t % 2 != 0}) {
      mesh.triangles.push_back(is_top ? top.triangles[t] : back);
      mesh.triangle_materials.push_back(is_top ? 0 : 1);
    }
  }
  mesh.material_names = {"top", "underside"};
  return mesh;
}

SimplifyResult simplifyTo(const TriangleMesh& mesh, int triangles) {
  SimplifyOptions options;
  options.triangles = triangles;
  return simplify(mesh, options, "leaf");
}

// All of a material face up (1) or down (−1).
void expectFacing(const TriangleMesh& mesh, std::uint32_t material, double sign) {
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
    if (mesh.triangle_materials[t] != material) continue;
    for (const std::uint32_t v : mesh.triangles[t]) EXPECT_GT(sign * mesh.normals[v][1], 0.5);
  }
}

TEST(Sheets, BothSidesStay) {
  for (const bool apart : {false, true}) {
    for (const int triangles : {1000, 60}) {
      const SimplifyResult result = simplifyTo(leaf(8, apart), triangles);
      const auto count = formats::trianglesOfMaterials(result.mesh);
      EXPECT_EQ(result.report.repairs.sheet_triangles, 128);
      EXPECT_EQ(result.report.repairs.reversed_triangles, 0);
      EXPECT_TRUE(result.report.warnings.empty());
      EXPECT_EQ(count[0], count[1]);
      if (triangles == 1000) {
        EXPECT_EQ(count[0], 128u);
      } else {
        EXPECT_NEAR(static_cast<double>(count[0]), 30, 1);
      }
      EXPECT_LE(result.mesh.triangleCount(), static_cast<std::size_t>(triangles));
      expectFacing(result.mesh, 0, 1);
      expectFacing(result.mesh, 1, -1);
    }
  }
}

TEST(Sheets, EachSideKeepsItsTextureCoordinates) {
  const TriangleMesh mesh = simplifyTo(leaf(4, true), 1000).mesh;
  ASSERT_EQ(mesh.texcoords.size(), mesh.vertexCount());
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t)
    for (const std::uint32_t v : mesh.triangles[t])
      EXPECT_NEAR(mesh.texcoords[v][0],
                  (mesh.positions[v][0] + 1) / 4 + (mesh.triangle_materials[t] == 1 ? 0.5 : 0), 1e-6);
}

TEST(Sheets, WithoutMaterialsBothSidesStay) {
  TriangleMesh bare = leaf(8, false);
  bare.triangle_materials.clear();
  bare.material_names.clear();
  const TriangleMesh mesh = simplifyTo(bare, 1000).mesh;
  EXPECT_EQ(mesh.triangleCount(), 256u);
  EXPECT_TRUE(mesh.triangle_materials.empty());
}

TEST(Sheets, EachSideHasItsColor) {
  MeshImport import{.mesh = leaf(8, true)};
  const std::size_t half = import.mesh.vertexCount() / 2;
  for (std::size_t v = 0; v < 2 * half; ++v)
    import.mesh.colors.push_back(v < half ? Float3{0, 1, 0} : Float3{1, 1, 0});
  for (const bool with_materials : {true, false}) {
    if (!with_materials) import.mesh.triangle_materials.clear(), import.mesh.material_names.clear();
    const TriangleMesh mesh = simplifyTo(import.mesh, 100).mesh;
    const auto albedo = carryAlbedo(import, mesh, "leaf").colors;
    for (std::size_t v = 0; v < mesh.vertexCount(); ++v)
      EXPECT_EQ(albedo[v], mesh.normals[v][1] > 0 ? (Float3{0, 1, 0}) : (Float3{1, 1, 0}));
  }
}

// Doubled with the sides exchanged, as some games need it: the inside is never seen.
TEST(Sheets, ClosedBodiesStayOneSided) {
  TriangleMesh ball = tests::icosphere(2);
  const std::size_t triangles = ball.triangleCount();
  for (std::size_t t = 0; t < triangles; ++t) {
    const auto [a, b, c] = ball.triangles[t];
    ball.triangles.push_back({a, c, b});
  }
  const SimplifyResult result = simplifyTo(ball, 1000);
  EXPECT_EQ(result.mesh.triangleCount(), triangles);
  EXPECT_EQ(result.report.repairs.reversed_triangles, static_cast<std::int64_t>(triangles));
  EXPECT_GT(result.report.volume_out, 4);
  EXPECT_TRUE(result.report.warnings.empty());
}

// A few on a larger surface are no sheet.
TEST(Sheets, BacksOnPartOfASurfaceAreRemovedAndTold) {
  TriangleMesh half = leaf(8, false);
  std::size_t kept = 0;
  for (std::size_t t = 0; t < half.triangleCount(); ++t) {
    const bool back_at_left =
        half.triangle_materials[t] == 1 && half.positions[half.triangles[t][0]][0] < -0.1f;
    if (half.triangle_materials[t] == 1 && !back_at_left) continue;
    half.triangles[kept] = half.triangles[t];
    half.triangle_materials[kept++] = half.triangle_materials[t];
  }
  half.triangles.resize(kept);
  half.triangle_materials.resize(kept);
  const SimplifyResult result = simplifyTo(half, 1000);
  EXPECT_EQ(result.mesh.triangleCount(), 128u);
  EXPECT_EQ(result.report.repairs.lost_backs, static_cast<std::int64_t>(kept) - 128);
  ASSERT_EQ(result.report.warnings.size(), 1u);
  EXPECT_NE(result.report.warnings[0].find("back to back"), std::string::npos) << result.report.warnings[0];
}

// Light of one far lamp, five bands.
double irradianceOf(const transfer::Transfer& baked, std::size_t vertex, const Vec3& towards_lamp) {
  const std::vector<double> light = transport::evaluateSh(5, towards_lamp);
  double sum = 0;
  for (std::size_t i = 0; i < 25; ++i) sum += light[i] * static_cast<double>(baked.vectors[vertex * 25 + i]);
  return sum;
}

TEST(Sheets, EachSideHasItsOwnLight) {
  for (const int triangles : {1000, 60}) {
    const TriangleMesh mesh = simplifyTo(leaf(8, false), triangles).mesh;
    const transfer::Transfer baked =
        tests::bake(mesh, {.order = 5, .directions = 4096, .transport = transfer::Transport::kShadowed});
    EXPECT_EQ(baked.buried_vertices, 0u);
    const double full = 1 / std::numbers::pi;
    for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
      const double side = mesh.normals[v][1] > 0 ? 1 : -1;
      EXPECT_GT(irradianceOf(baked, v, Vec3(0, side, 0)), 0.6 * full);
      EXPECT_LT(std::abs(irradianceOf(baked, v, Vec3(0, -side, 0))), 0.1 * full);
    }
  }
}

}  // namespace
}  // namespace bakelight::simplify
