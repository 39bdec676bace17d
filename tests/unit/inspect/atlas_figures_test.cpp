#include "tools/inspect/atlas_figures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/unit/inspect/texcoord_meshes.h"

namespace bakelight::inspect {
namespace {

using formats::TriangleMesh;
using tests::appendSquare;
using tests::texturedSquare;

TEST(AtlasFigures, AnEvenSquareIsAnIsometryAtItsScale) {
  const AtlasFigures figures = measureAtlas(texturedSquare({0.25f, 0.5f}, {0.5f, 0.75f}));
  EXPECT_EQ(figures.charts, 1u);
  EXPECT_DOUBLE_EQ(figures.unit_square_share, 0.0625);
  EXPECT_NEAR(figures.l2_stretch, 1, 1e-12);
  for (const double stretch : figures.triangle_stretch) EXPECT_NEAR(stretch, 1, 1e-12);
  EXPECT_EQ(figures.flipped_triangles + figures.collapsed_triangles + figures.triangles_outside, 0u);
  // Only the diagonal lies inside.
  EXPECT_EQ(figures.chart_borders[0], (std::array<std::uint8_t, 3>{1, 1, 0}));
  EXPECT_EQ(figures.chart_borders[1], (std::array<std::uint8_t, 3>{0, 1, 1}));
}

TEST(AtlasFigures, StretchOfARectangleAndOfUnequalShares) {
  // 1/4 by 1/3: Γ² + γ² is 16 + 9, the plane's area 1/12.
  const AtlasFigures uneven = measureAtlas(texturedSquare({0, 0}, {0.25f, 1.0f / 3}));
  EXPECT_NEAR(uneven.l2_stretch, std::sqrt(25.0 / 2 / 12), 1e-6);
  // Two equal squares, one with four times the texture: lengths 1/2 and 1/4, area 5/16 of 2.
  TriangleMesh mesh = texturedSquare({0, 0}, {0.5f, 0.5f});
  appendSquare(mesh, {3, 0, 0}, 1, {0.5f, 0.5f}, {0.75f, 0.75f});
  const AtlasFigures unequal = measureAtlas(mesh);
  EXPECT_EQ(unequal.charts, 2u);
  EXPECT_NEAR(unequal.l2_stretch, std::sqrt((4.0 + 16) / 2 * 5 / 32), 1e-6);
  EXPECT_NEAR(unequal.triangle_stretch[0], 2 * std::sqrt(5.0 / 32), 1e-6);
  EXPECT_NEAR(unequal.triangle_stretch[2], 4 * std::sqrt(5.0 / 32), 1e-6);
}

TEST(AtlasFigures, CopiesOfVerticesHangTogetherUnlessTexcoordsDiffer) {
  TriangleMesh joined = texturedSquare({0, 0}, {0.25f, 0.25f});
  appendSquare(joined, {1, 0, 0}, 1, {0.25f, 0}, {0.5f, 0.25f});
  EXPECT_EQ(measureAtlas(joined).charts, 1u);
  TriangleMesh parted = texturedSquare({0, 0}, {0.25f, 0.25f});
  appendSquare(parted, {1, 0, 0}, 1, {0.5f, 0}, {0.75f, 0.25f});
  EXPECT_EQ(measureAtlas(parted).charts, 2u);
}

TEST(AtlasFigures, MirroredChartsAndFlippedTrianglesAreToldApart) {
  TriangleMesh mesh = texturedSquare({0.25f, 0}, {0, 0.25f});
  EXPECT_EQ(measureAtlas(mesh).mirrored_charts, 1u);
  EXPECT_EQ(measureAtlas(mesh).flipped_triangles, 0u);
  EXPECT_NEAR(measureAtlas(mesh).l2_stretch, 1, 1e-12);
  mesh = texturedSquare({0, 0}, {0.5f, 0.5f});
  mesh.texcoords[3] = {0.4f, 0.1f};  // to the right of the diagonal
  const AtlasFigures folded = measureAtlas(mesh);
  EXPECT_EQ(folded.mirrored_charts, 0u);
  EXPECT_EQ(folded.flipped_triangles, 1u);
}

TEST(AtlasFigures, CollapsedTrianglesAndThoseOutsideAreCounted) {
  TriangleMesh mesh = texturedSquare({0, 0}, {1.5f, 1});
  EXPECT_EQ(measureAtlas(mesh).triangles_outside, 2u);
  EXPECT_DOUBLE_EQ(measureAtlas(mesh).unit_square_share, 1.5);
  mesh = texturedSquare({0, 0}, {0.5f, 0.5f});
  mesh.texcoords[3] = {0.25f, 0.25f};
  const AtlasFigures figures = measureAtlas(mesh);
  EXPECT_EQ(figures.collapsed_triangles, 1u);
  EXPECT_TRUE(std::isinf(figures.l2_stretch));
  EXPECT_TRUE(std::isinf(figures.triangle_stretch[1]));
  EXPECT_TRUE(std::isfinite(figures.triangle_stretch[0]));
  // A triangle that the surface does not have stretches nothing.
  TriangleMesh slit = texturedSquare({0, 0}, {0.5f, 0.5f});
  slit.triangles.push_back({0, 2, 2});
  EXPECT_EQ(measureAtlas(slit).triangle_stretch[2], 1);
  EXPECT_NEAR(measureAtlas(slit).l2_stretch, 1, 1e-12);
}

TEST(AtlasFigures, NeighborsGetDifferentNumbers) {
  // 5 × 5 squares, a chart each.
  TriangleMesh mesh;
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 5; ++x) {
      const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
      appendSquare(mesh, {fx, fy, 0}, 1, {fx / 5, fy / 5}, {(fx + 0.9f) / 5, (fy + 0.9f) / 5});
    }
  const AtlasFigures figures = measureAtlas(mesh);
  ASSERT_EQ(figures.charts, 25u);
  const std::vector<std::uint32_t> numbers = alternateNumbers(mesh, figures, 12);
  for (std::size_t i = 0; i < 25; ++i) {
    if (i % 5 != 4) {
      EXPECT_NE(numbers[i], numbers[i + 1]);
    }
    if (i < 20) {
      EXPECT_NE(numbers[i], numbers[i + 5]);
    }
  }
  EXPECT_EQ(std::set<std::uint32_t>(numbers.begin(), numbers.end()).size(), 12u);
}

}  // namespace
}  // namespace bakelight::inspect
