// Patches at the edge of sense: deep, with holes, black, white, glossy, mirrors.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/patches.h"
#include "tools/rtt/rtt.h"
#include "transport/hemisphere_grid.h"
#include "transport/sh.h"

namespace bakelight::rtt {
namespace {

using formats::RadianceTransferTexture;
using patch::PatchGeometry;

const double kUniformSky = std::sqrt(4 * std::numbers::pi);

Options small(int resolution, int views) {
  Options options;
  options.resolution = options.elements = resolution;
  options.views = views;
  return options;
}

double meanUnderUniformSky(const RadianceTransferTexture& texture) {
  double sum = 0;
  for (std::size_t r = 0; r < texture.values.size(); r += texture.responseSize()) sum += texture.values[r];
  return kUniformSky * sum * static_cast<double>(texture.responseSize()) /
         static_cast<double>(texture.values.size());
}

bool allFinite(const RadianceTransferTexture& texture) {
  return std::all_of(texture.values.begin(), texture.values.end(), [](float v) { return std::isfinite(v); });
}

// Walls along x, `share` of a period thick and `depth` high.
PatchGeometry grooves(double depth, double share, float albedo) {
  return tests::heightPatch(32, depth, [=](double x, double) { return x < share ? 1.0 : 0.0; },
                            {albedo, albedo, albedo});
}

TEST(StiffRtt, BlackIsBlack) {
  const Rtt made = makeRtt(tests::heightPatch(12, 0.5, tests::waves, {0, 0, 0}), small(8, 3), [] {});
  for (const float value : made.texture.values) ASSERT_EQ(value, 0);
  EXPECT_EQ(made.figures.view_dependence.from_mean, 0);
}

// In widths of the patch; views near the horizon cross many of them. Depth changes what is seen of what, and the energy
// stays: white walls under a uniform sky are white.
TEST(StiffRtt, WhiteGroovesDeeperThanThePatchAreAFurnace) {
  for (const double depth : {1.0, 4.0}) {
    Options options = small(16, 8);
    options.elements = 5;
    const Rtt made = makeRtt(grooves(depth, 0.5, 1), options, [] {});
    EXPECT_TRUE(allFinite(made.texture));
    EXPECT_EQ(made.figures.hole_share, 0);
    EXPECT_NEAR(meanUnderUniformSky(made.texture), 1, 0.02) << depth;
  }
}

// The solver against plain bounces until nothing is left.
TEST(StiffRtt, DeepGroovesOfAlbedo099AreSolved) {
  const PatchGeometry geometry = grooves(2, 0.25, 0.99F);
  Options options = small(8, 2);
  options.elements = 5;
  const Rtt solved = makeRtt(geometry, options, [] {});
  EXPECT_TRUE(solved.figures.bounced->converged);
  options.bounces = 250;
  const Rtt bounced = makeRtt(geometry, options, [] {});
  const double right = meanUnderUniformSky(bounced.texture);
  EXPECT_NEAR(meanUnderUniformSky(solved.texture), right, 2e-3 * right);
  options.bounces = 3;
  EXPECT_LT(meanUnderUniformSky(makeRtt(geometry, options, [] {}).texture),
            0.97 * right);  // what truncation loses
}

// A sheet with a square hole of a quarter of its area: straight through it, and past its edges from aside.
TEST(StiffRtt, HolesGiveNothingAndAreCounted) {
  formats::TriangleMesh mesh;
  for (int y = 0; y <= 2; ++y)
    for (int x = 0; x <= 2; ++x)
      mesh.positions.push_back({0.5F * static_cast<float>(x), 0.5F * static_cast<float>(y), 0});
  for (const auto& [a, b, c] :
       {formats::Triangle{1, 2, 5}, {1, 5, 4}, {3, 4, 7}, {3, 7, 6}, {4, 5, 8}, {4, 8, 7}})
    mesh.triangles.push_back({a, b, c});
  formats::PatchMesh settings;
  settings.period = {1, 1};
  PatchGeometry sheet = patch::meshPatch(mesh, settings, true, "sheet");
  sheet.albedo = {1, 1, 1};
  const Rtt made = makeRtt(sheet, small(8, 4), [] {});
  EXPECT_NEAR(made.figures.hole_share, 0.25,
              1e-6);  // a thin hole is as large for all views through its plane
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x) {
      const bool is_hole = x < 4 && y >= 4;
      EXPECT_NEAR(kUniformSky * made.texture.response(0, 2, x, y)[0], is_hole ? 0 : 1, 1e-5) << x << " " << y;
    }
  EXPECT_NEAR(made.figures.mean_albedo[0], 0.75, 1e-5);
}

// A surface above another, seen from behind by it: its back is lit by what comes from below.
TEST(StiffRtt, BacksOfOpenSheetsAreLit) {
  formats::TriangleMesh mesh;
  const auto square = [&](float side, float z) {
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    for (const auto& [x, y] : {std::array{0.F, 0.F}, {side, 0.F}, {side, side}, {0.F, side}})
      mesh.positions.push_back({x, y, z});
    mesh.triangles.insert(mesh.triangles.end(), {{base, base + 1, base + 2}, {base, base + 2, base + 3}});
  };
  square(1, 0);
  square(0.5F, 0.25F);
  formats::PatchMesh settings;
  settings.period = {1, 1};
  PatchGeometry geometry = patch::meshPatch(mesh, settings, true, "sheets");
  geometry.albedo = {1, 1, 1};
  const Rtt made = makeRtt(geometry, small(16, 1), [] {});
  // White, closed by the floor: all is as bright as the sky, beneath the sheet, too.
  EXPECT_NEAR(meanUnderUniformSky(made.texture), 1, 0.02);
  EXPECT_EQ(made.figures.inside_share, 0);
}

formats::GgxReflection white(double roughness) {
  return {{1, 1, 1}, roughness, false, roughness > 0};
}

// The mirror image of the sky above a flat mirror: B_i = y_i(mirrored direction), to rounding.
TEST(GlossyRtt, FlatMirrorShowsTheSky) {
  PatchGeometry geometry = tests::flatPatch({0, 0, 0});
  geometry.reflection = white(0);
  const Rtt made = makeRtt(geometry, small(4, 4), [] {});
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) {
      const transport::Vec3 view = transport::hemisphereCell(4, column, row);
      const std::vector<double> right = transport::evaluateSh(5, {-view.x(), -view.y(), view.z()});
      const auto response = made.texture.response(column, row, 1, 2);
      for (std::size_t i = 0; i < 25; ++i) EXPECT_NEAR(response[i], right[i], 2e-5) << column << row << i;
    }
}

// Light that mirrors hand from one to another is followed until it leaves: white mirrors and white facets lose none.
TEST(GlossyRtt, WhiteMirrorsAndFacetsAreAFurnace) {
  for (const double roughness : {0.0, 0.3, 0.7}) {
    PatchGeometry geometry = tests::heightPatch(24, 0.3, tests::waves, {0, 0, 0});
    geometry.reflection = white(roughness);
    Options options = small(12, 3);
    options.glossy_samples = 64;
    EXPECT_NEAR(meanUnderUniformSky(makeRtt(geometry, options, [] {}).texture), 1, 0.025) << roughness;
  }
}

// Phong's lobe turns to a mirror as its exponent grows.
TEST(GlossyRtt, SharpLobesTendToTheMirror) {
  PatchGeometry geometry = tests::heightPatch(24, 0.1, tests::waves, {0, 0, 0});
  geometry.reflection = white(0);
  const Rtt mirror = makeRtt(geometry, small(12, 3), [] {});
  geometry.reflection = formats::PhongReflection{{1, 1, 1}, 50'000};
  const Rtt sharp = makeRtt(geometry, small(12, 3), [] {});
  double differences = 0, squares = 0;
  for (std::size_t i = 0; i < mirror.texture.values.size(); ++i) {
    differences += std::pow(mirror.texture.values[i] - sharp.texture.values[i], 2);
    squares += std::pow(mirror.texture.values[i], 2);
  }
  EXPECT_LT(std::sqrt(differences / squares), 0.03);
}

TEST(Rtt, LevelsAveragedAreLevelsRendered) {
  const PatchGeometry geometry = tests::heightPatch(24, 0.3, tests::waves, {0.8F, 0.8F, 0.8F});
  Options options = small(16, 2);
  const RadianceTransferTexture fine = makeRtt(geometry, options, [] {}).texture;
  options.resolution = 8, options.supersampling = 4;  // the same points
  const RadianceTransferTexture coarse = makeRtt(geometry, options, [] {}).texture;
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x)
      for (std::size_t i = 0; i < 25; ++i) {
        float mean = 0;
        for (int k = 0; k < 4; ++k) mean += fine.response(1, 0, 2 * x + k % 2, 2 * y + k / 2)[i] / 4;
        EXPECT_NEAR(mean, coarse.response(1, 0, x, y)[i], 1e-6);
      }
}

TEST(Rtt, WithoutMaskingAllViewsAreAlike) {
  const PatchGeometry geometry = tests::heightPatch(16, 0.3, tests::waves, {0.8F, 0.8F, 0.8F});
  Options options = small(8, 3);
  EXPECT_GT(makeRtt(geometry, options, [] {}).figures.view_dependence.from_mean, 0.05);
  options.masking = false;
  const Rtt without = makeRtt(geometry, options, [] {});
  EXPECT_LT(without.figures.view_dependence.from_mean, 1e-6);
  EXPECT_TRUE(without.texture.heights.empty());
}

// Walls 0.4 high with floors between: from the zenith each texel of a wall has its top, of a floor its floor, and the edges of
// texels lie on those of walls. Aslant no view sees anything higher or lower.
TEST(Rtt, HeightsAreThoseOfWhatIsSeen) {
  const PatchGeometry geometry = grooves(0.4, 0.5, 0.5F);
  Options options = small(32, 1);
  EXPECT_TRUE(makeRtt(geometry, options, [] {}).texture.heights.empty());  // all see one place
  options.views = 3;
  const RadianceTransferTexture texture = makeRtt(geometry, options, [] {}).texture;
  ASSERT_EQ(texture.heights.size(), texture.responseCount());
  const auto [lowest, highest] = std::minmax_element(texture.heights.begin(), texture.heights.end());
  EXPECT_NEAR(*highest - *lowest, 0.4, 1e-5);
  int tops = 0, floors = 0;
  for (int x = 0; x < 32; ++x) {
    const float height = texture.heights[texture.responseIndex(1, 1, x, 16)];
    tops += height > *highest - 1e-5F, floors += height < *lowest + 1e-5F;
  }
  EXPECT_GE(tops, 14);
  EXPECT_GE(floors, 13);
  EXPECT_EQ(makeRtt(tests::heightPatch(16, 0.0, tests::waves, {1, 1, 1}), small(8, 2), [] {}).texture.heights,
            std::vector<float>(4 * 64, 0.0F));
}

TEST(Rtt, WithoutShadowsPitsAreBrighter) {
  Options options = small(16, 1);
  options.bounces = 0;
  options.elements = 5;
  const PatchGeometry geometry = grooves(1, 0.5, 0.8F);
  const double shadowed = meanUnderUniformSky(makeRtt(geometry, options, [] {}).texture);
  options.shadows = false;
  const double open = meanUnderUniformSky(makeRtt(geometry, options, [] {}).texture);
  EXPECT_GT(open, 1.2 * shadowed);
  EXPECT_NEAR(open, 0.8, 0.1);  // from straight above, tops and grounds alone
}

}  // namespace
}  // namespace bakelight::rtt
