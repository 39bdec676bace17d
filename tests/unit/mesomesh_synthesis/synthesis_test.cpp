#include "tools/mesomesh/synthesis/synthesize.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tests/support/exemplars.h"
#include "tests/support/rippled_ball.h"
#include "tests/support/textured_surface.h"

namespace bakelight::mesomesh {
namespace {

const tests::TexturedSurface& ball() {
  static const tests::TexturedSurface surface = tests::texturedSurface(tests::rippledBall(5000));
  return surface;
}

TEST(Synthesis, IsTheSameForAnyThreadsAndRanges) {
  const std::vector<Exemplar> exemplars = {makeExemplar(tests::stones(32, 8), {}, "")};
  SynthesisOptions options;
  const PatchCoordinates any = synthesize(ball().view(), exemplars, options);
  ASSERT_EQ(any.coordinates.size(), ball().mesh.vertexCount());
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(synthesize(ball().view(), exemplars, options).coordinates, any.coordinates);
  }
  for (const std::size_t ranges : {1, 7}) {
    options.ranges = ranges;
    const PatchCoordinates cut = synthesize(ball().view(), exemplars, options);
    EXPECT_EQ(cut.coordinates, any.coordinates);
    EXPECT_EQ(cut.report.quality.neighborhood_error, any.report.quality.neighborhood_error);
    EXPECT_EQ(cut.report.quality.seam_ratio, any.report.quality.seam_ratio);
  }
  options.seed = 1;
  EXPECT_NE(synthesize(ball().view(), exemplars, options).coordinates, any.coordinates);
}

// Cuts are joined again, so that they leave no trace.
TEST(Synthesis, DoesNotDependOnCuts) {
  const std::vector<Exemplar> exemplars = {makeExemplar(tests::stones(32, 8), {}, "")};
  const tests::TexturedSurface cut = tests::cut(ball());
  const std::vector<formats::Float2> coordinates = synthesize(cut.view(), exemplars, {}).coordinates;
  std::map<formats::Float3, formats::Float2> at;
  std::size_t doubled = 0;
  for (std::size_t v = 0; v < coordinates.size(); ++v) {
    const auto [place, added] = at.emplace(cut.mesh.positions[v], coordinates[v]);
    EXPECT_EQ(place->second, coordinates[v]);
    doubled += added ? 0 : 1;
  }
  EXPECT_GT(doubled, 50U);
}

TEST(Synthesis, StaysInsideOfWhatIsNotPeriodic) {
  for (const int side : {9, 12, 40}) {
    const std::vector<Exemplar> exemplars = {makeExemplar(tests::stochastic(side), {false, {}}, "")};
    const PatchCoordinates patch = synthesize(ball().view(), exemplars, {});
    // Windows of 5 texels a side are inside where two texels on each side are.
    const float least = 2.49f / static_cast<float>(side);
    const float smallest_step =
        static_cast<float>(patch.report.levels[0].spacing / patch.report.texel_sizes[0]);
    EXPECT_FLOAT_EQ(smallest_step, 1);
    for (const formats::Float2& at : patch.coordinates)
      for (const float axis : at) {
        EXPECT_GE(axis, least);
        EXPECT_LE(axis, 1 - least);
      }
    EXPECT_LT(patch.report.quality.neighborhood_error_ratio, 1.3);
    EXPECT_GT(patch.report.quality.coverage, 0.1);
  }
}

TEST(Synthesis, UsesAllOfWhatIsNotPeriodic) {
  const tests::TexturedSurface large = tests::texturedSurface(tests::rippledBall(80000));
  const std::vector<Exemplar> exemplars = {makeExemplar(tests::stochastic(40), {false, {}}, "")};
  EXPECT_GT(synthesize(large.view(), exemplars, {}).report.quality.coverage, 0.85);
}

TEST(Synthesis, TakesSeveralExemplars) {
  tests::TexturedSurface surface = ball();
  for (std::size_t v = 0; v < surface.mesh.vertexCount(); ++v)
    surface.exemplars[v] = surface.mesh.positions[v][1] > 0.2f ? 1 : 0;
  std::vector<Exemplar> exemplars = {makeExemplar(tests::stones(32, 8), {}, "stones"),
                                     makeExemplar(tests::stochastic(24), {}, "grains")};
  const PatchCoordinates patch = synthesize(surface.view(), exemplars, {});
  EXPECT_GT(patch.report.quality.seam_vertices, 50U);
  EXPECT_LT(patch.report.quality.neighborhood_error_ratio, 1.25);
  EXPECT_LT(patch.report.quality.seam_ratio, 1.5);
  // Neither knows of the other: the lower half comes out the same beside anything else.
  exemplars[1] = makeExemplar(tests::checks(16, 2), {}, "checks");
  const PatchCoordinates other = synthesize(surface.view(), exemplars, {});
  for (std::size_t v = 0; v < surface.mesh.vertexCount(); ++v)
    ASSERT_TRUE(surface.exemplars[v] == 1 || patch.coordinates[v] == other.coordinates[v]) << v;
}

// On one half of a torus frames are turned by a quarter. A checkered exemplar shows nothing of it.
TEST(Synthesis, TurnsSymmetricExemplarsWithTheField) {
  tests::TexturedSurface surface = tests::flatTorus(64);
  for (std::size_t v = 0; v < surface.tangents.size(); ++v)
    if (v % 64 >= 32) surface.tangents[v] = {0, 0, -1};
  SynthesisOptions options;
  options.randomness = 0;
  options.folds = FieldFolds::kFour;
  const formats::Image checks = tests::checks(32, 2);
  const std::vector<Exemplar> exemplars = {makeExemplar(checks, {true, 1.0}, "")};
  const PatchCoordinates turned = synthesize(surface.view(), exemplars, options);
  EXPECT_LT(turned.report.quality.neighborhood_error, 1e-5);
  EXPECT_EQ(turned.report.quality.seam_vertices, 4U * 64);
  EXPECT_GT(turned.report.quality.coherent_share, 0.999);
  // The picture on the surface repeats every 16 vertices in both directions, across the turn too.
  const formats::TriangleMesh mesh = tests::painted(surface, checks, turned.coordinates);
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v)
    EXPECT_NEAR(mesh.colors[v][0], mesh.colors[v / 64 * 64 + (v % 64 + 16) % 64][0], 0.02);
  options.folds = FieldFolds::kOne;
  EXPECT_GT(synthesize(surface.view(), exemplars, options).report.twisted_vertices, 0U);
}

TEST(Synthesis, TakesTheScaleThatIsAsked) {
  tests::TexturedSurface surface = tests::flatTorus(96);
  SynthesisOptions options;
  options.randomness = 0;
  for (const double texel_size : {0.5, 1.0, 1.5, 3.0}) {
    const std::vector<Exemplar> exemplars = {makeExemplar(tests::stones(32, 8), {true, texel_size}, "")};
    const PatchCoordinates patch = synthesize(surface.view(), exemplars, options);
    const float step = std::fmod(patch.coordinates[1][0] - patch.coordinates[0][0] + 1, 1.0f);
    EXPECT_NEAR(step, 1 / (32 * texel_size), 1e-4) << texel_size;
    EXPECT_LT(patch.report.quality.neighborhood_error, 1e-3) << texel_size;
  }
}

TEST(Synthesis, RepeatsNothingWhenItIsRandom) {
  const tests::TexturedSurface surface = tests::flatTorus(192);
  const std::vector<Exemplar> exemplars = {makeExemplar(tests::stones(32, 8), {true, 1.0}, "")};
  const std::vector<formats::Float2> coordinates = synthesize(surface.view(), exemplars, {}).coordinates;
  // The share of vertices that show what is a period away.
  std::size_t same = 0;
  for (std::size_t v = 0; v < coordinates.size(); ++v) {
    const formats::Float2 &a = coordinates[v], &b = coordinates[v / 192 * 192 + (v % 192 + 32) % 192];
    const float du = std::remainder(a[0] - b[0], 1.0f), dv = std::remainder(a[1] - b[1], 1.0f);
    same += std::hypot(du, dv) < 1 / 32.0f ? 1 : 0;
  }
  EXPECT_LT(same, coordinates.size() / 5);
}

}  // namespace
}  // namespace bakelight::mesomesh
