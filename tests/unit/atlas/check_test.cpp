#include "tools/atlas/check.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/mesh_ply.h"
#include "tests/support/shapes.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/atlas/texture_quads.h"
#include "tools/atlas/check_report.h"

using namespace bakelight;
using atlas::AtlasFigures;
using formats::TriangleMesh;
using tests::addQuad;
using tests::Rectangle;

namespace {

AtlasFigures figuresOf(const TriangleMesh& mesh, int resolution) {
  return atlas::check(atlas::atlasOf(mesh), resolution, "mesh");
}

// Squares apart on the surface, in texels of an 16² atlas.
TriangleMesh squares(std::initializer_list<Rectangle> texels) {
  TriangleMesh mesh;
  float x = 0;
  for (const auto& [left, bottom, right, top] : texels) {
    addQuad(mesh, {x, 0, x + right - left, top - bottom}, {left / 16, bottom / 16, right / 16, top / 16});
    x += 100;
  }
  return mesh;
}

TEST(AtlasCheck, ASquareHasNoDefectAndTheFiguresOfAnIsometry) {
  const AtlasFigures figures = figuresOf(squares({{2, 3, 10, 8}}), 16);
  EXPECT_EQ(figures.defects(), 0);
  EXPECT_EQ(figures.charts, 1);
  EXPECT_EQ(figures.triangles, 2);
  EXPECT_EQ(figures.utilisation, 40.0 / 256);
  EXPECT_EQ(figures.touched, 40.0 / 256);
  EXPECT_EQ(figures.smallest_gutter, 16);
  EXPECT_EQ(figures.triangles_below_texel, 0);
  EXPECT_NEAR(figures.l2_stretch, 1, 1e-12);
  EXPECT_NEAR(figures.l_infinity_stretch, 1, 1e-12);
  EXPECT_NEAR(figures.mean_anisotropy, 1, 1e-12);
  EXPECT_NEAR(figures.worst_chart_l2, 1, 1e-12);
  EXPECT_EQ(figures.texel_density_spread, 1);
  EXPECT_NEAR(figures.border_length, 26 / std::sqrt(40.0), 1e-6);
}

// √((a/b + b/a) / 2) for the singular values a and b; L∞ of the larger by the root of the area.
TEST(AtlasCheck, StretchOfALinearMapIsItsClosedForm) {
  TriangleMesh mesh;
  addQuad(mesh, {0, 0, 1, 1}, {0, 0, 1, 0.5F});
  addQuad(mesh, {10, 0, 11, 1}, {0, 0.5F, 0.25F, 0.625F});  // a quarter of the scale
  const AtlasFigures figures = figuresOf(mesh, 64);
  EXPECT_NEAR(figures.worst_chart_l2, std::sqrt(1.25), 1e-6);
  EXPECT_NEAR(figures.mean_anisotropy, 2, 1e-6);
  EXPECT_NEAR(figures.texel_density_spread, 4, 1e-6);
  const double plane_area = (0.5 + 0.5 / 16) / 2, mean = (1 + 4.0) / 2 * (1 + 16) / 2;
  EXPECT_NEAR(figures.l2_stretch, std::sqrt(mean * plane_area), 1e-6);
  EXPECT_NEAR(figures.l_infinity_stretch, 8 * std::sqrt(plane_area), 1e-6);
}

TEST(AtlasCheck, GuttersAreCountedInFreeTexels) {
  EXPECT_EQ(figuresOf(squares({{0, 0, 4, 4}, {4, 0, 8, 4}}), 16).smallest_gutter, 0);
  EXPECT_EQ(figuresOf(squares({{0, 0, 4, 4}, {6, 0, 8, 4}}), 16).smallest_gutter, 2);
  EXPECT_EQ(figuresOf(squares({{0, 0, 4, 4}, {7, 9, 8, 10}}), 16).smallest_gutter, 5);  // along a diagonal
  EXPECT_EQ(figuresOf(squares({{0, 0, 4, 4}, {7, 1, 8, 2}, {14, 1, 15, 2}}), 16).smallest_gutter, 3);
  // Half a texel further each: the texels between are touched from both sides.
  EXPECT_EQ(figuresOf(squares({{0, 0, 4.5, 4}, {5.5, 0, 8, 4}}), 16).smallest_gutter, 0);
  EXPECT_EQ(figuresOf(squares({{0, 0, 4.25, 4}, {4.75, 0, 8, 4}}), 16).smallest_gutter, -1);
}

TEST(AtlasCheck, ChartsThatAbutHaveNoDefectButNoGutter) {
  const AtlasFigures figures = figuresOf(squares({{0, 0, 4, 4}, {4, 1, 8, 6}, {4, 6, 8, 7}}), 16);
  EXPECT_EQ(figures.defects(), 0);
  EXPECT_EQ(figures.smallest_gutter, 0);
}

TEST(AtlasCheck, BarsThatCrossDoSoInFourPairsOfEdges) {
  const AtlasFigures figures = figuresOf(squares({{0, 5, 12, 7}, {4, 0, 6, 14}}), 16);
  EXPECT_EQ(figures.crossing_edges, 4);
  EXPECT_EQ(figures.overlapping_texels, 4);
  EXPECT_EQ(figures.smallest_gutter, -1);
  EXPECT_EQ(figures.defects(), 8);
}

TEST(AtlasCheck, OverlapsThatNoTexelSeesAreSeenByTheBorders) {
  // One hundredth of a texel; a corner that enters through an edge; one chart on another.
  EXPECT_GT(figuresOf(squares({{0, 0, 4, 4}, {3.99F, 1, 6, 3}}), 16).crossing_edges, 0);
  EXPECT_EQ(figuresOf(squares({{0, 0, 4, 4}, {3.99F, 1, 6, 3}}), 16).overlapping_texels, 0);
  EXPECT_EQ(figuresOf(squares({{2, 2, 14, 14}, {2, 2, 14, 14}}), 16).crossing_edges, 4);
  EXPECT_EQ(figuresOf(squares({{0, 0, 4, 4}, {0, 0, 4, 4}}), 16).overlapping_texels, 16);
  EXPECT_GT(figuresOf(squares({{0, 0, 4, 4}, {1, 0, 2, 1}}), 16).crossing_edges, 0);
}

// Two edges that begin on the square's left one: inside it, or outside.
TEST(AtlasCheck, ACornerOnAnEdgeCrossesWhereItGoesOnInside) {
  for (const float inwards : {1.F, -1.F}) {
    TriangleMesh mesh = squares({{4, 0, 12, 8}});
    for (const auto& [x, y] : {std::pair{0.F, 4.F}, {inwards * 2, 4 - inwards}, {inwards * 2, 4 + inwards}}) {
      mesh.positions.push_back({x, y, 5});
      mesh.normals.push_back({0, 0, 1});
      mesh.texcoords.push_back({(4 + x) / 16, y / 16});
    }
    mesh.triangles.push_back({4, 5, 6});
    const AtlasFigures figures = figuresOf(mesh, 16);
    EXPECT_EQ(figures.flipped, 0);
    EXPECT_EQ(figures.crossing_edges, inwards > 0 ? 2 : 0);
  }
}

TEST(AtlasCheck, TrianglesThatTurnAgainstTheirChartAreFlipped) {
  TriangleMesh mesh;
  for (const auto& [x, y] : {std::pair{0.F, 0.F}, {8.F, 0.F}, {8.F, 8.F}, {0.F, 8.F}}) {
    mesh.positions.push_back({x, y, 0});
    mesh.texcoords.push_back({x / 16, y / 16});
  }
  mesh.positions.push_back({9, 9, 0});
  mesh.texcoords.push_back({5 / 16.F, 5 / 16.F});  // folded back onto the square
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 4, 2}};
  const AtlasFigures figures = figuresOf(mesh, 16);
  EXPECT_EQ(figures.flipped, 1);
  EXPECT_EQ(figures.mirrored_charts, 0);
  EXPECT_GT(figures.overlapping_texels, 0);
  EXPECT_NEAR(figures.l2_stretch, 1, 1e-6);  // of the other two
}

TEST(AtlasCheck, AMirroredChartIsNoDefect) {
  TriangleMesh mesh = squares({{0, 0, 4, 4}, {6, 0, 8, 4}});
  for (std::size_t v = 4; v < 8; ++v) mesh.texcoords[v][0] = 1 - mesh.texcoords[v][0];
  const AtlasFigures figures = figuresOf(mesh, 16);
  EXPECT_EQ(figures.mirrored_charts, 1);
  EXPECT_EQ(figures.defects(), 0);
  EXPECT_NEAR(figures.l2_stretch, 1, 1e-12);
}

TEST(AtlasCheck, WhatLiesOutsideOrHasCollapsedCounts) {
  TriangleMesh mesh = squares({{0, 0, 4, 4}, {8, 0, 12, 4}});
  mesh.texcoords[6] = mesh.texcoords[5];  // the first triangle of the second square
  mesh.texcoords[0] = {-0.01F, 0};
  mesh.texcoords[3][1] = std::numeric_limits<float>::quiet_NaN();
  const AtlasFigures figures = figuresOf(mesh, 16);
  EXPECT_EQ(figures.outside, 2);
  EXPECT_EQ(figures.collapsed, 2);  // that and the one that is not a number
}

TEST(AtlasCheck, TrianglesWithoutAreaOnTheSurfaceDoNotSeparateAChart) {
  TriangleMesh mesh = squares({{0, 0, 8, 8}});
  mesh.triangles.push_back({0, 0, 2});
  mesh.triangles.push_back({2, 0, 2});
  const AtlasFigures figures = figuresOf(mesh, 16);
  EXPECT_EQ(figures.charts, 1);
  EXPECT_EQ(figures.defects(), 0);
  EXPECT_EQ(figures.smallest_gutter, 16);
  EXPECT_NEAR(figures.border_length, 4, 1e-6);
}

TEST(AtlasCheck, SmallTrianglesAreCounted) {
  const AtlasFigures figures = figuresOf(squares({{0, 0, 1, 1}, {4, 4, 4.25F, 4.25F}, {8, 8, 12, 12}}), 16);
  EXPECT_EQ(figures.triangles_below_texel, 4);    // halves of one texel, too
  EXPECT_EQ(figures.triangles_without_texel, 3);  // one half has the centre on its edge
}

// Every triangle over the whole square: as textures with a picture for each triangle have it.
TEST(AtlasCheck, AThousandfoldOverlapEndsSoon) {
  TriangleMesh mesh = tests::icosphere(4);
  TriangleMesh apart;
  for (const formats::Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      apart.positions.push_back(mesh.positions[t[k]]);
      apart.texcoords.push_back({k == 1 ? 1.F : 0.F, k == 2 ? 1.F : 0.F});
    }
  for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t)
    apart.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  const AtlasFigures figures = figuresOf(apart, 256);
  EXPECT_EQ(figures.crossing_edges, atlas::kMostCrossings);
  EXPECT_EQ(figures.smallest_gutter, -1);
  EXPECT_EQ(figures.overlapping_texels, 256 * 255 / 2);
}

TEST(AtlasOf, ChartsAreNumberedByTheirFirstTrianglesAndShareNoVertex) {
  TriangleMesh mesh = squares({{0, 0, 4, 4}, {4, 4, 8, 8}});
  mesh.colors.assign(8, {0.5F, 0, 0});
  mesh.triangles[2][0] = 2;  // a corner in common
  mesh.positions[4] = mesh.positions[2];
  const atlas::Atlas result = atlas::atlasOf(mesh);
  EXPECT_EQ(result.chart_count, 2u);
  EXPECT_EQ(result.triangle_charts, (std::vector<std::uint32_t>{0, 0, 1, 1}));
  EXPECT_EQ(result.mesh.vertexCount(), 9u);
  EXPECT_EQ(result.mesh.triangles[2][0], 8u);
  EXPECT_EQ(result.mesh.positions[8], mesh.positions[2]);
  EXPECT_EQ(result.mesh.normals.size(), 9u);
  EXPECT_EQ(result.mesh.colors.size(), 9u);
}

// Copies of vertices with one position and one texture coordinate are one; a seam in either is a seam.
TEST(AtlasOf, SeamsSeparateCopiesDoNot) {
  TriangleMesh joined;
  addQuad(joined, {0, 0, 1, 1}, {0, 0, 0.25F, 0.25F});
  addQuad(joined, {1, 0, 2, 1}, {0.25F, 0, 0.5F, 0.25F});
  EXPECT_EQ(atlas::atlasOf(joined).chart_count, 1u);
  TriangleMesh apart_in_texture = joined;
  for (std::size_t v = 4; v < 8; ++v) apart_in_texture.texcoords[v][0] += 0.25F;
  EXPECT_EQ(atlas::atlasOf(apart_in_texture).chart_count, 2u);
  TriangleMesh apart_in_space = joined;
  for (std::size_t v = 4; v < 8; ++v) apart_in_space.positions[v][2] += 1;
  EXPECT_EQ(atlas::atlasOf(apart_in_space).chart_count, 2u);
  TriangleMesh turned = joined;
  std::swap(turned.triangles[2][1], turned.triangles[2][2]);
  std::swap(turned.triangles[3][1], turned.triangles[3][2]);
  EXPECT_EQ(atlas::atlasOf(turned).chart_count, 2u);
  EXPECT_THROW(atlas::atlasOf(tests::icosphere(0)), std::logic_error);
}

TEST(AtlasCheckReport, AMeshWithoutTextureCoordinatesIsToldNotThrown) {
  const atlas::CheckReport report = atlas::reportOf(tests::icosphere(0), 64, 3, "mesh");
  EXPECT_EQ(report.defects, 20);
  EXPECT_EQ(report.gutter_shortfall, 3);
  EXPECT_FALSE(report.isValid());
  EXPECT_THROW(atlas::check({tests::icosphere(0), {}, 0}, 64, "mesh"), Error);
}

TEST(AtlasCheckReport, TheShortfallIsOfTheGutterAlone) {
  const TriangleMesh mesh = squares({{0, 0, 4, 4}, {6, 0, 8, 4}});
  EXPECT_EQ(atlas::reportOf(mesh, 16, 2, "mesh").gutter_shortfall, 0);
  EXPECT_EQ(atlas::reportOf(mesh, 16, 5, "mesh").gutter_shortfall, 3);
  EXPECT_EQ(atlas::reportOf(mesh, 16, 5, "mesh").defects, 0);
}

TEST(AtlasCheckTool, FailsWithWordsWhenAskedTo) {
  const tests::TemporaryFolder folder;
  const std::string tool = std::string(BAKELIGHT_BIN_DIR) + "/atlas_check ";
  const std::string mesh = (folder.path() / "mesh.ply").string();
  formats::writePly(mesh, squares({{0, 0, 4, 4}, {6, 0, 8, 4}}));
  const std::string arguments = tool + mesh + " --resolution 16 --require-valid --gutter ";
  EXPECT_EQ(tests::shell(arguments + "2").status, 0);
  const auto failed = tests::shell(arguments + "3");
  EXPECT_EQ(failed.status, 2);
  EXPECT_THAT(failed.output, testing::HasSubstr("1 texels short"));
}

}  // namespace
