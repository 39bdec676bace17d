// Files from import to albedo: what people export, small.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "formats/materials.h"
#include "formats/mesh_import.h"
#include "tools/simplify/colors.h"
#include "tools/simplify/simplify.h"

namespace bakelight::simplify {
namespace {

namespace fs = std::filesystem;
using formats::Float3;
using formats::MeshImport;
using formats::TriangleMesh;

const fs::path kCases = fs::path(BAKELIGHT_SOURCE_DIR) / "tests/cases";

// What the tool does, with its defaults.
SimplifyResult simplified(const fs::path& file, const fs::path& texture = {}) {
  MeshImport import = formats::importMesh(kCases / file);
  if (!texture.empty()) replaceAlbedo(import, kCases / texture, file.string());
  SimplifyResult result = simplify(import.mesh, {}, file.string());
  result.mesh.colors = carryAlbedo(import, result.mesh, file.string()).colors;
  return result;
}

void expectNear(const Float3& color, const Float3& expected) {
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(color[c], expected[c], 1e-6);
}

TEST(CaseFiles, ColorsOfMtlMaterialsByFace) {
  const TriangleMesh mesh = simplified("obj/mtl_colours/box.obj").mesh;
  EXPECT_EQ(mesh.material_names, (std::vector<std::string>{"red", "green"}));
  for (const std::size_t count : formats::trianglesOfMaterials(mesh)) EXPECT_GT(count, 0u);
  ASSERT_EQ(mesh.colors.size(), mesh.vertexCount());
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t)
    for (const std::uint32_t v : mesh.triangles[t])
      expectNear(mesh.colors[v],
                 mesh.triangle_materials[t] == 0 ? Float3{0.8f, 0.05f, 0.05f} : Float3{0.05f, 0.8f, 0.05f});
}

TEST(CaseFiles, BaseColorFactor) {
  const TriangleMesh mesh = simplified("gltf/base_colour_factor.gltf").mesh;
  ASSERT_EQ(mesh.colors.size(), mesh.vertexCount());
  for (const Float3& color : mesh.colors) expectNear(color, {0.8f, 0.1f, 0.1f});
}

TEST(CaseFiles, ATransformedTextureShowsItsOtherHalf) {
  for (const fs::path& texture : {fs::path(), fs::path("gltf/texture_transform/tex.png")}) {
    const TriangleMesh mesh = simplified("gltf/texture_transform/moved.gltf", texture).mesh;
    ASSERT_EQ(mesh.colors.size(), mesh.vertexCount());
    for (const Float3& color : mesh.colors) EXPECT_GT(color[2], color[0] + 0.5f);
  }
}

TEST(CaseFiles, TextureCoordinatesOfFaceCorners) {
  for (const fs::path& texture : {fs::path(), fs::path("ply/wedge/tex.png")}) {
    const TriangleMesh mesh = simplified("ply/wedge/cube.ply", texture).mesh;
    ASSERT_EQ(mesh.colors.size(), mesh.vertexCount());
    // Sides across x are red, across y green, across z blue.
    for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
      const Float3& n = mesh.normals[v];
      for (std::size_t c = 0; c < 3; ++c) {
        if (std::abs(n[c]) < 0.9f) continue;
        EXPECT_GT(mesh.colors[v][c], mesh.colors[v][(c + 1) % 3] + 0.5f);
        EXPECT_GT(mesh.colors[v][c], mesh.colors[v][(c + 2) % 3] + 0.5f);
      }
    }
  }
}

TEST(CaseFiles, ALeafHasTwoSides) {
  const SimplifyResult result = simplified("obj/leaf_two_sheets.obj");
  EXPECT_EQ(result.mesh.triangleCount(), 256u);
  EXPECT_EQ(result.report.repairs.sheet_triangles, 128);
  std::size_t up = 0;
  for (const Float3& n : result.mesh.normals) up += n[1] > 0;
  EXPECT_EQ(2 * up, result.mesh.vertexCount());
}

TEST(CaseFiles, WhatUtmCoordinatesLoseIsTold) {
  const SimplifyResult result = simplified("far/utm.obj");
  EXPECT_THAT(result.report.warnings,
              testing::ElementsAre(testing::AllOf(testing::HasSubstr("160 of 320 triangles (50 %)"),
                                                  testing::HasSubstr("move the mesh to the origin"))));
}

TEST(CaseFiles, ATinyBodyIsAsAtAnyOtherScale) {
  MeshImport import = formats::importMesh(kCases / "far/tiny_1e-06.obj");
  const SimplifyResult tiny = simplify(import.mesh, {}, "tiny");
  for (Float3& p : import.mesh.positions)
    for (float& x : p) x *= 1048576;  // a power of two: the same digits
  const SimplifyResult large = simplify(import.mesh, {}, "large");
  EXPECT_TRUE(tiny.report.warnings.empty());
  EXPECT_EQ(tiny.mesh.triangles, large.mesh.triangles);
  EXPECT_EQ(tiny.mesh.normals, large.mesh.normals);
}

}  // namespace
}  // namespace bakelight::simplify
