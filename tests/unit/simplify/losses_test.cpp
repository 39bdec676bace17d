#include "surface/losses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/error.h"
#include "tests/support/shapes.h"
#include "tools/simplify/simplify.h"
#include "tools/simplify/surface_words.h"

namespace bakelight::simplify {
namespace {

using formats::TriangleMesh;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

SimplifyResult simplified(const TriangleMesh& mesh, double weld_tolerance = 1e-7) {
  SimplifyOptions options;
  options.triangles = 100000;
  options.weld_tolerance = weld_tolerance;
  return simplify(mesh, options, "body.obj");
}

TriangleMesh moved(TriangleMesh mesh, const formats::Float3& by, double scale = 1) {
  for (auto& p : mesh.positions)
    for (std::size_t c = 0; c < 3; ++c) p[c] = static_cast<float>(scale * p[c] + static_cast<double>(by[c]));
  return mesh;
}

TEST(Losses, ACleanBodyIsNoCause) {
  EXPECT_TRUE(simplified(tests::icosphere(4)).report.warnings.empty());
  EXPECT_TRUE(simplified(moved(tests::icosphere(4), {1000, 0, 0})).report.warnings.empty());
}

// The weld's tolerance is that of the ball; only the six needles that reach out to the vertex go.
TEST(Losses, AVertexAstrayCostsNothingAndIsNamed) {
  TriangleMesh ball = tests::icosphere(5);
  ball.positions[77] = {0, 1e6f, 0};
  const SimplifyResult result = simplified(ball);
  EXPECT_EQ(result.mesh.triangleCount(), ball.triangleCount() - 6);
  EXPECT_THAT(result.report.warnings,
              ElementsAre(AllOf(HasSubstr("vertex 77 at (0, 1e+06, 0)"), HasSubstr("lies 999999 away"))));
}

TEST(Losses, CoordinatesTooFarForFloatsAreTold) {
  const SimplifyResult result = simplified(moved(tests::icosphere(4), {5e5f, 0, 4649776}));
  EXPECT_THAT(result.report.warnings,
              testing::Contains(AllOf(HasSubstr("floats are 0.5 apart"), HasSubstr(" of 5120 triangles ("),
                                      HasSubstr("collapsed"), HasSubstr("move the mesh to the origin"))));
}

TEST(Losses, WhatTheWeldTakesIsTold) {
  const SimplifyResult result = simplified(tests::icosphere(5), 0.01);
  EXPECT_THAT(result.report.warnings,
              testing::Contains(AllOf(HasSubstr("welded"), HasSubstr("weld_tolerance"))));
}

TEST(Losses, RepeatedTrianglesAreTold) {
  TriangleMesh ball = tests::icosphere(2);
  const auto once = ball.triangles;
  ball.triangles.insert(ball.triangles.end(), once.begin(), once.end());
  EXPECT_THAT(simplified(ball).report.warnings, ElementsAre(HasSubstr("320 of 640 triangles (50 %)")));
}

TEST(Losses, PolesOfASphereOfRingsAreNoCause) {
  // Four of sixty-four triangles have two corners at the pole: nothing is lost with them.
  TriangleMesh ball = tests::icosphere(2);
  for (std::uint32_t i = 0; i < 8; ++i) {
    const auto twin = static_cast<std::uint32_t>(ball.vertexCount());
    ball.positions.push_back(formats::Float3(ball.positions[0]));
    ball.triangles.push_back({0, twin, i + 1});
  }
  ball.normals.clear();
  EXPECT_TRUE(simplified(ball).report.warnings.empty());
}

TEST(Losses, PartsThatFaceInwardsAreTold) {
  TriangleMesh ball = tests::insideOut(tests::icosphere(2));
  EXPECT_THAT(simplified(ball).report.warnings, ElementsAre(HasSubstr("1 closed part faced inwards")));
}

TEST(Losses, EveryScaleWithinTheRangeGivesTheSameTriangles) {
  const SimplifyResult one = simplified(tests::icosphere(2));
  for (const double scale : {1e-17, 1e-6, 1e6, 1e17}) {
    const SimplifyResult result = simplified(moved(tests::icosphere(2), {0, 0, 0}, scale));
    EXPECT_EQ(result.mesh.triangles, one.mesh.triangles) << scale;
    EXPECT_TRUE(result.report.warnings.empty()) << scale;
  }
}

TEST(Losses, ScalesOutOfTheRangeAreRefused) {
  for (const double scale : {1e-19, 1e19}) {
    try {
      simplified(moved(tests::icosphere(2), {0, 0, 0}, scale));
      FAIL() << scale;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr("body.obj"), HasSubstr("scale the mesh"))) << scale;
    }
  }
}

TEST(Losses, TrianglesThatRoundingTakesFromTheResultAreTold) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 3}, {1, 2, 3}};
  EXPECT_THAT(roundingWarnings(mesh), ElementsAre(HasSubstr("1 of 2 triangles (50 %)")));
  mesh.triangles.pop_back();
  EXPECT_TRUE(roundingWarnings(mesh).empty());
}

}  // namespace
}  // namespace bakelight::simplify
