// Surfaces and exemplars at the edge of sense: right, or refused by name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "formats/error.h"
#include "tests/support/exemplars.h"
#include "tests/support/rippled_ball.h"
#include "tests/support/textured_surface.h"
#include "tools/mesomesh/synthesis/synthesize.h"

namespace bakelight::mesomesh {
namespace {

using testing::HasSubstr;

PatchCoordinates synthesized(const tests::TexturedSurface& surface, const formats::Image& image,
                             const ExemplarSettings& settings = {}, const SynthesisOptions& options = {}) {
  const std::vector<Exemplar> exemplars = {makeExemplar(image, settings, "patch.exr")};
  PatchCoordinates patch = synthesize(surface.view(), exemplars, options);
  EXPECT_EQ(patch.coordinates.size(), surface.mesh.vertexCount());
  for (const formats::Float2& at : patch.coordinates)
    for (const float axis : at) EXPECT_TRUE(axis >= 0 && axis < 1) << axis;
  const SynthesisQuality& q = patch.report.quality;
  for (const double figure : {q.neighborhood_error, q.neighborhood_error_ratio, q.random_ratio,
                              q.coherent_share, q.coverage, q.entropy, q.seam_ratio})
    EXPECT_TRUE(std::isfinite(figure) && figure >= 0) << figure;
  return patch;
}

std::string refusal(const tests::TexturedSurface& surface, const ExemplarSettings& settings = {},
                    const SynthesisOptions& options = {},
                    const formats::Image& image = tests::stones(16, 3)) {
  try {
    synthesized(surface, image, settings, options);
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    return error.what();
  }
  return "";
}

const tests::TexturedSurface& ball() {
  static const tests::TexturedSurface surface = tests::texturedSurface(tests::rippledBall(3000));
  return surface;
}

TEST(StiffExemplars, AConstantIsRightAnywhere) {
  const PatchCoordinates patch = synthesized(ball(), tests::constantImage());
  EXPECT_EQ(patch.report.quality.neighborhood_error, 0);
  EXPECT_EQ(patch.report.quality.neighborhood_error_ratio, 1);
}

TEST(StiffExemplars, SmallerThanTheirNeighborhood) {
  for (const int side : {1, 2, 3, 4}) synthesized(ball(), tests::whiteNoise(side));
  tests::TexturedSurface torus = tests::flatTorus(48);
  SynthesisOptions options;
  options.randomness = 0;
  EXPECT_EQ(synthesized(torus, tests::whiteNoise(3), {true, 1.0}, options).report.quality.neighborhood_error,
            0);
}

TEST(StiffExemplars, WhiteNoise) {
  const SynthesisQuality quality = synthesized(ball(), tests::whiteNoise(32)).report.quality;
  EXPECT_LT(quality.neighborhood_error_ratio, 1.25);
  EXPECT_GT(quality.coverage, 0.8);
}

TEST(StiffExemplars, OfOtherScalesThanTheMesh) {
  const double spacing = synthesized(ball(), tests::stones(16, 3)).report.levels[0].spacing;
  for (const double factor : {1e-30, 1e-3, 0.05})
    EXPECT_THAT(refusal(ball(), {true, factor * spacing}), HasSubstr("of its texels apart"));
  for (const double factor : {0.2, 5.0, 1e3, 1e30}) EXPECT_EQ(refusal(ball(), {true, factor * spacing}), "");
}

TEST(StiffExemplars, ThatDoNotSuitTheField) {
  SynthesisOptions options;
  options.folds = FieldFolds::kFour;
  formats::Image oblong(16, 8, {"Y"});
  EXPECT_THAT(refusal(ball(), {}, options, oblong), HasSubstr("a square exemplar"));
  options.folds = FieldFolds::kTwo;
  EXPECT_EQ(refusal(ball(), {}, options, oblong), "");
}

TEST(StiffSurfaces, WithoutVertices) {
  synthesized({}, tests::stones(16, 3));
}

TEST(StiffSurfaces, OneTriangle) {
  tests::TexturedSurface surface;
  surface.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 0, -1}};
  surface.mesh.triangles = {{0, 1, 2}};
  surface = tests::texturedSurface(surface.mesh);
  synthesized(surface, tests::stones(16, 3));
}

TEST(StiffSurfaces, VerticesWithoutTriangles) {
  tests::TexturedSurface surface = ball();
  surface.mesh.triangles.clear();
  synthesized(surface, tests::stones(16, 3));
}

TEST(StiffSurfaces, AMoebiusStrip) {
  constexpr std::uint32_t kAlong = 200, kAcross = 12;
  formats::TriangleMesh mesh;
  for (std::uint32_t a = 0; a < kAlong; ++a)
    for (std::uint32_t w = 0; w < kAcross; ++w) {
      const double angle = 2 * std::numbers::pi * a / kAlong, across = (w / (kAcross - 1.0) - 0.5) * 0.35;
      const double radius = 1 + across * std::cos(angle / 2);
      mesh.positions.push_back({static_cast<float>(radius * std::cos(angle)),
                                static_cast<float>(across * std::sin(angle / 2)),
                                static_cast<float>(radius * std::sin(angle))});
      if (w + 1 == kAcross) continue;
      const auto next = [&](std::uint32_t row) {
        return a + 1 < kAlong ? (a + 1) * kAcross + row : kAcross - 1 - row;
      };
      mesh.triangles.push_back({a * kAcross + w, a * kAcross + w + 1, next(w)});
      mesh.triangles.push_back({a * kAcross + w + 1, next(w + 1), next(w)});
    }
  for (const FieldFolds folds : {FieldFolds::kOne, FieldFolds::kTwo, FieldFolds::kFour}) {
    SynthesisOptions options;
    options.folds = folds;
    const SynthesisQuality quality =
        synthesized(tests::texturedSurface(mesh), tests::stones(24, 5), {}, options).report.quality;
    EXPECT_LT(quality.neighborhood_error_ratio, 1.5);
  }
}

TEST(StiffSurfaces, AFanOfAThousandTriangles) {
  formats::TriangleMesh mesh;
  mesh.positions.push_back({0, 0.1f, 0});
  for (std::uint32_t a = 0; a < 1000; ++a) {
    const double angle = 2 * std::numbers::pi * a / 1000;
    mesh.positions.push_back({static_cast<float>(std::cos(angle)), 0, static_cast<float>(-std::sin(angle))});
    mesh.triangles.push_back({0, a + 1, (a + 1) % 1000 + 1});
  }
  synthesized(tests::texturedSurface(mesh), tests::stones(16, 3));
}

TEST(StiffSurfaces, TenThousandComponents) {
  formats::TriangleMesh mesh;
  const tests::TexturedSurface piece = tests::flatSheet(3, 3);
  for (std::uint32_t c = 0; c < 10000; ++c) {
    const auto begin = static_cast<std::uint32_t>(mesh.vertexCount());
    for (const formats::Float3& p : piece.mesh.positions)
      mesh.positions.push_back(
          {p[0] + 5.0f * static_cast<float>(c % 100), p[1], p[2] + 5.0f * static_cast<float>(c / 100)});
    for (const auto& [a, b, d] : piece.mesh.triangles)
      mesh.triangles.push_back({begin + a, begin + b, begin + d});
  }
  const PatchCoordinates patch = synthesized(tests::texturedSurface(mesh), tests::stones(16, 3));
  EXPECT_GT(patch.report.quality.coverage, 0.9);
}

// A crease of 170° between two sheets is an edge like any other to those who live on it.
TEST(StiffSurfaces, ASharpCrease) {
  tests::TexturedSurface sheet = tests::flatSheet(80, 80);
  const double half_angle = 85 * std::numbers::pi / 180;
  for (formats::Float3& p : sheet.mesh.positions) {
    const double x = p[0] - 40.0;
    p[0] = static_cast<float>(std::cos(half_angle) * std::abs(x) * (x < 0 ? -1 : 1));
    p[1] = static_cast<float>(-std::sin(half_angle) * std::abs(x));
  }
  const PatchCoordinates patch =
      synthesized(tests::texturedSurface(sheet.mesh, {0, 0, 1}), tests::stones(32, 8));
  EXPECT_LT(patch.report.quality.neighborhood_error_ratio, 1.25);
}

TEST(StiffSurfaces, SizesAndPlacesOfAnyKind) {
  for (const double scale : {1e-18, 1e-6, 1e6, 1e15}) {
    tests::TexturedSurface surface = ball();
    for (formats::Float3& p : surface.mesh.positions)
      for (float& axis : p) axis = static_cast<float>(axis * scale);
    EXPECT_LT(synthesized(surface, tests::stones(16, 3)).report.quality.neighborhood_error_ratio, 1.3)
        << scale;
  }
  // So far away that vertices fall together.
  tests::TexturedSurface surface = ball();
  for (formats::Float3& p : surface.mesh.positions)
    for (float& axis : p) axis += 1e6f;
  synthesized(surface, tests::stones(16, 3));
}

TEST(StiffSurfaces, ValuesThatMakeNoSenseAreRefused) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto damaged = [](const auto& damage) {
    tests::TexturedSurface surface = ball();
    damage(surface);
    return refusal(surface);
  };
  EXPECT_THAT(damaged([&](auto& s) { s.mesh.positions[7][1] = nan; }),
              HasSubstr("vertex 7: its position is not finite"));
  EXPECT_THAT(damaged([&](auto& s) {
                s.mesh.normals[8] = {0, 0, 0};
              }),
              HasSubstr("vertex 8: its normal has no direction"));
  EXPECT_THAT(damaged([&](auto& s) { s.tangents[9][0] = nan; }), HasSubstr("vertex 9: its tangent"));
  EXPECT_THAT(damaged([&](auto& s) { s.exemplars[3] = 1; }), HasSubstr("vertex 3: it takes exemplar 1 of 1"));
  EXPECT_THAT(damaged([&](auto& s) { s.mesh.triangles[5][2] = 99999; }),
              HasSubstr("triangle 5: its vertex 99999 does not exist"));
  EXPECT_THAT(damaged([&](auto& s) { s.tangents.pop_back(); }), HasSubstr("tangents"));
  EXPECT_EQ(damaged([&](auto& s) { s.tangents[4] = s.mesh.normals[4]; }), "");
}

}  // namespace
}  // namespace bakelight::mesomesh
