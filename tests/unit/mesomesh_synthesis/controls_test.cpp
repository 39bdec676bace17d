// Figures of quality where their values are known.
#include <gtest/gtest.h>

#include "tests/support/exemplars.h"
#include "tests/support/rippled_ball.h"
#include "tests/support/textured_surface.h"
#include "tools/mesomesh/synthesis/synthesize.h"

namespace bakelight::mesomesh {
namespace {

std::vector<Exemplar> one(const formats::Image& image, ExemplarSettings settings = {}) {
  return {makeExemplar(image, settings, "exemplar")};
}

// 128 vertices a side and an exemplar of 64 texels: nothing hinders its tiling.
TEST(SynthesisControls, WithoutRandomnessAFlatTorusIsTiledExactly) {
  const tests::TexturedSurface surface = tests::flatTorus(128);
  SynthesisOptions options;
  options.randomness = 0;
  for (const formats::Image& image : {tests::weave(), tests::stones(), tests::stochastic()}) {
    const PatchCoordinates patch = synthesize(surface.view(), one(image, {true, 1.0}), options);
    EXPECT_EQ(patch.report.quality.neighborhood_error, 0);
    EXPECT_EQ(patch.report.quality.neighborhood_error_ratio, 1);
    EXPECT_EQ(patch.report.quality.coherent_share, 1);
    EXPECT_EQ(patch.report.quality.coverage, 1);
    EXPECT_DOUBLE_EQ(patch.report.quality.entropy, 1);
    // u runs along +x, v along −z, a texel a unit.
    const formats::Float2 a = patch.coordinates[0], right = patch.coordinates[1],
                          nearer = patch.coordinates[128];
    EXPECT_FLOAT_EQ(std::fmod(right[0] - a[0] + 1, 1.0f), 1 / 64.0f);
    EXPECT_FLOAT_EQ(right[1], a[1]);
    EXPECT_FLOAT_EQ(nearer[0], a[0]);
    EXPECT_FLOAT_EQ(std::fmod(a[1] - nearer[1] + 1, 1.0f), 1 / 64.0f);
  }
}

TEST(SynthesisControls, RandomPlacesAreTold) {
  const tests::TexturedSurface surface = tests::flatSheet(60, 60);
  std::vector<formats::Float2> coordinates;
  for (std::size_t v = 0; v < surface.mesh.vertexCount(); ++v)
    coordinates.push_back(
        {static_cast<float>(tests::hashedUnit(1, v)), static_cast<float>(tests::hashedUnit(2, v))});
  const SynthesisQuality quality = qualityOf(surface.view(), one(tests::stones(16, 3)), {}, coordinates);
  EXPECT_GT(quality.neighborhood_error, 0.5);
  EXPECT_GT(quality.neighborhood_error_ratio, 3);
  EXPECT_LT(quality.coherent_share, 0.01);
  EXPECT_GT(quality.coverage, 0.9);
}

TEST(SynthesisControls, FiguresOfCoordinatesAreThoseOfTheirSynthesis) {
  const tests::TexturedSurface surface = tests::texturedSurface(tests::rippledBall(3000));
  const std::vector<Exemplar> exemplars = one(tests::stones(32, 8));
  const PatchCoordinates patch = synthesize(surface.view(), exemplars, {});
  const SynthesisQuality again = qualityOf(surface.view(), exemplars, {}, patch.coordinates);
  EXPECT_NEAR(again.neighborhood_error, patch.report.quality.neighborhood_error, 1e-4);
  EXPECT_NEAR(again.coherent_share, patch.report.quality.coherent_share, 1e-3);
}

TEST(SynthesisControls, ExhaustiveSearchIsTheMeasure) {
  const tests::TexturedSurface surface = tests::texturedSurface(tests::rippledBall(1500));
  const std::vector<Exemplar> exemplars = one(tests::stones(16, 3));
  SynthesisOptions options;
  const SynthesisQuality coherent = synthesize(surface.view(), exemplars, options).report.quality;
  options.method = SynthesisMethod::kFull;
  const SynthesisQuality full = synthesize(surface.view(), exemplars, options).report.quality;
  EXPECT_GE(full.neighborhood_error_ratio, 1);
  EXPECT_LT(full.neighborhood_error_ratio, 1.03);
  EXPECT_LE(full.neighborhood_error_ratio, coherent.neighborhood_error_ratio);
}

TEST(SynthesisControls, SynthesisIsCloseToTheMeasure) {
  const tests::TexturedSurface surface = tests::cut(tests::texturedSurface(tests::rippledBall(10000)));
  for (const formats::Image& image : {tests::weave(32), tests::stones(24, 5), tests::stochastic(24)}) {
    const SynthesisQuality quality = synthesize(surface.view(), one(image), {}).report.quality;
    EXPECT_LT(quality.neighborhood_error_ratio, 1.2);
    EXPECT_GT(quality.random_ratio, 10);
    EXPECT_GT(quality.coherent_share, 0.4);
    EXPECT_LT(quality.coherent_share, 0.95);
    EXPECT_GT(quality.coverage, 0.8);
    // Of few vertices, on a body of strong curvature.
    EXPECT_GT(quality.seam_vertices, 100U);
    EXPECT_NEAR(quality.seam_ratio, 1, 0.35);
  }
}

TEST(SynthesisControls, ASeamIsToldWhereItIs) {
  tests::TexturedSurface surface = tests::flatTorus(64);
  SynthesisOptions options;
  options.randomness = 0;
  const std::vector<Exemplar> exemplars = one(tests::stones(), {true, 1.0});
  std::vector<formats::Float2> coordinates = synthesize(surface.view(), exemplars, options).coordinates;
  std::vector<std::uint8_t> on_seam(surface.mesh.vertexCount());
  for (std::size_t v = 0; v < coordinates.size(); ++v) {
    const std::size_t x = v % 64;
    if (x >= 32) coordinates[v][1] = std::fmod(coordinates[v][1] + 0.3f, 1.0f);
    on_seam[v] = x % 32 < 2 || x % 32 > 29 ? 1 : 0;
  }
  options.on_seam = on_seam;
  const SynthesisQuality quality = qualityOf(surface.view(), exemplars, options, coordinates);
  EXPECT_GT(quality.seam_ratio, 100);
  EXPECT_EQ(quality.seam_vertices, 64U * 8);
}

}  // namespace
}  // namespace bakelight::mesomesh
