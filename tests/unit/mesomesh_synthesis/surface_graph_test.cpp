#include "tools/mesomesh/synthesis/surface_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/rippled_ball.h"
#include "tests/support/textured_surface.h"
#include "tools/mesomesh/synthesis/coarsening.h"
#include "tools/mesomesh/synthesis/level_plan.h"

namespace bakelight::mesomesh {
namespace {

const Link* linkBetween(const SurfaceGraph& graph, std::uint32_t from, std::uint32_t to) {
  for (const Link& link : graph.linksOf(from))
    if (link.to == to) return &link;
  return nullptr;
}

TEST(SurfaceGraph, LinksAreTheirOwnReverse) {
  const tests::TexturedSurface surface = tests::texturedSurface(tests::rippledBall(2000));
  for (const FieldFolds folds : {FieldFolds::kOne, FieldFolds::kTwo, FieldFolds::kFour}) {
    const SurfaceGraph graph = graphOf(surface.view(), folds, 1).graph;
    ASSERT_GT(graph.links.size(), 5000U);
    for (std::uint32_t v = 0; v < graph.vertexCount(); ++v)
      for (const Link& link : graph.linksOf(v)) {
        const Link* back = linkBetween(graph, link.to, v);
        ASSERT_NE(back, nullptr);
        const Link expected = reversed(link, v);
        EXPECT_EQ(back->turns, expected.turns);
        EXPECT_EQ(back->offset, expected.offset);
      }
  }
}

// A cylinder is flat: around it and along it distances on the surface are those of the paper it is rolled of.
TEST(SurfaceGraph, MeasuresAlongTheSurface) {
  constexpr std::uint32_t kAround = 64, kAlong = 8;
  tests::TexturedSurface surface;
  const double side = 2 * std::sin(std::numbers::pi / kAround);
  for (std::uint32_t y = 0; y < kAlong; ++y)
    for (std::uint32_t a = 0; a < kAround; ++a) {
      const double angle = 2 * std::numbers::pi * a / kAround;
      surface.mesh.positions.push_back({static_cast<float>(std::sin(angle)), static_cast<float>(side * y),
                                        static_cast<float>(std::cos(angle))});
      surface.mesh.normals.push_back(
          {static_cast<float>(std::sin(angle)), 0, static_cast<float>(std::cos(angle))});
      surface.tangents.push_back(
          {static_cast<float>(std::cos(angle)), 0, static_cast<float>(-std::sin(angle))});
      const std::uint32_t v = y * kAround + a, right = y * kAround + (a + 1) % kAround;
      if (y + 1 == kAlong) continue;
      surface.mesh.triangles.push_back({v, right, right + kAround});
      surface.mesh.triangles.push_back({v, right + kAround, v + kAround});
    }
  surface.exemplars.assign(surface.mesh.vertexCount(), 0);
  const MeshGraph mesh = graphOf(surface.view(), FieldFolds::kOne, 1);
  for (std::uint32_t y = 0; y + 1 < kAlong; ++y)
    for (std::uint32_t a = 0; a < kAround; ++a) {
      const auto vertex = [&](std::uint32_t around, std::uint32_t along) {
        return mesh.vertex_of[along * kAround + around % kAround];
      };
      const Link* right = linkBetween(mesh.graph, vertex(a, y), vertex(a + 1, y));
      const Link* up = linkBetween(mesh.graph, vertex(a, y), vertex(a, y + 1));
      ASSERT_TRUE(right != nullptr && up != nullptr);
      EXPECT_NEAR(right->offset[0], side, 1e-5);
      EXPECT_NEAR(right->offset[1], 0, 1e-5);
      EXPECT_NEAR(up->offset[0], 0, 1e-5);
      EXPECT_NEAR(up->offset[1], side, 1e-5);
    }
}

TEST(SurfaceGraph, CutsAreJoinedAndSheetsAreNot) {
  const tests::TexturedSurface whole = tests::texturedSurface(tests::rippledBall(4000));
  const tests::TexturedSurface cut = tests::cut(whole);
  ASSERT_GT(cut.mesh.vertexCount(), whole.mesh.vertexCount() + 50);
  const MeshGraph graph = graphOf(cut.view(), FieldFolds::kOne, 1);
  EXPECT_EQ(graph.graph.vertexCount(), whole.mesh.vertexCount());
  EXPECT_EQ(graph.welded_vertices, cut.mesh.vertexCount() - whole.mesh.vertexCount());
  EXPECT_EQ(graph.graph.links.size(), graphOf(whole.view(), FieldFolds::kOne, 1).graph.links.size());

  // Two sheets on one place that face away from each other.
  tests::TexturedSurface sheets = tests::flatSheet(5, 5);
  const auto count = static_cast<std::uint32_t>(sheets.mesh.vertexCount());
  for (std::uint32_t v = 0; v < count; ++v) {
    sheets.mesh.positions.push_back(sheets.mesh.positions[v]);
    sheets.mesh.normals.push_back({0, -1, 0});
    sheets.tangents.push_back({1, 0, 0});
    sheets.exemplars.push_back(0);
  }
  const std::vector<formats::Triangle> upper = sheets.mesh.triangles;
  for (const auto& [a, b, c] : upper) sheets.mesh.triangles.push_back({a + count, c + count, b + count});
  EXPECT_EQ(graphOf(sheets.view(), FieldFolds::kOne, 1).graph.vertexCount(), 2U * count);
}

// Frames of a flat torus turned by a quarter on one half: the field of four folds sees no difference.
TEST(SurfaceGraph, FieldsOfFourFoldsTurn) {
  tests::TexturedSurface surface = tests::flatTorus(16);
  for (std::size_t v = 0; v < surface.tangents.size(); ++v)
    if (v % 16 >= 8) surface.tangents[v] = {0, 0, -1};
  const MeshGraph four = graphOf(surface.view(), FieldFolds::kFour, 1),
                  one = graphOf(surface.view(), FieldFolds::kOne, 1);
  EXPECT_EQ(four.twisted_vertices, 0U);
  EXPECT_EQ(one.twisted_vertices, 64U);
  // From an unturned vertex to a turned one: the turned frame's u points along the other's v.
  const Link* link = linkBetween(four.graph, four.vertex_of[7], four.vertex_of[8]);
  ASSERT_NE(link, nullptr);
  EXPECT_EQ(link->turns, 1U);
  EXPECT_EQ(link->offset, (Offset{1, 0}));
  EXPECT_EQ(linkBetween(four.graph, four.vertex_of[8], four.vertex_of[7])->offset, (Offset{0, 1}));
}

TEST(Coarsening, KeepsFarVerticesAndTheirDistances) {
  const MeshGraph mesh = graphOf(tests::flatTorus(64).view(), FieldFolds::kOne, 1);
  const tests::TexturedSurface surface = tests::flatTorus(64);
  const Coarsening coarsening = coarsened(mesh.graph, 5);
  const double ratio =
      static_cast<double>(mesh.graph.vertexCount()) / static_cast<double>(coarsening.coarse.vertexCount());
  EXPECT_GT(ratio, 3);
  EXPECT_LT(ratio, 5);
  std::vector<std::uint32_t> original(mesh.graph.vertexCount());
  for (std::uint32_t v = 0; v < mesh.vertex_of.size(); ++v) original[mesh.vertex_of[v]] = v;
  const auto place = [&](std::uint32_t coarse) {
    return surface.mesh.positions[original[coarsening.fine_of_coarse[coarse]]];
  };
  for (std::uint32_t c = 0; c < coarsening.coarse.vertexCount(); ++c) {
    for (const Link& link : mesh.graph.linksOf(coarsening.fine_of_coarse[c])) {
      EXPECT_FALSE(
          std::binary_search(coarsening.fine_of_coarse.begin(), coarsening.fine_of_coarse.end(), link.to));
      EXPECT_LE(squaredLength(coarsening.parents[link.to]), 2);
    }
    for (const Link& link : coarsening.coarse.linksOf(c)) {
      EXPECT_FLOAT_EQ(link.offset[0], std::remainder(place(link.to)[0] - place(c)[0], 64.0f));
      EXPECT_FLOAT_EQ(link.offset[1], -std::remainder(place(link.to)[2] - place(c)[2], 64.0f));
    }
  }
}

// What a vertex reads is never written at the same time.
TEST(LevelPlan, NoVertexReadsItsOwnClass) {
  const MeshGraph mesh =
      graphOf(tests::texturedSurface(tests::rippledBall(6000)).view(), FieldFolds::kOne, 1);
  const std::vector<Exemplar> exemplars = {makeExemplar(formats::Image(16, 16, {"Y"}), {}, "")};
  const AppearanceLevel appearance(exemplars[0], 1, 0);
  const std::vector<ExemplarScale> scales = {{mesh.graph.meanLength(), &appearance}};
  const LevelPlan plan = planOf(mesh.graph, scales);
  std::vector<std::size_t> classes(mesh.graph.vertexCount());
  for (std::size_t c = 0; c < plan.classCount(); ++c)
    for (std::size_t o = plan.class_first[c]; o < plan.class_first[c + 1]; ++o) classes[plan.order[o]] = c;
  EXPECT_LE(plan.classCount(), 16U);
  std::size_t predicted = 0;
  for (std::size_t v = 0; v < classes.size(); ++v) {
    for (const Predictor& predictor : plan.samples[v]) {
      if (predictor.weight == 0) continue;
      EXPECT_NE(classes[predictor.vertex], classes[v]);
      ++predicted;
    }
    for (const Proposer& proposer : plan.proposersOf(v)) EXPECT_NE(classes[proposer.vertex], classes[v]);
  }
  EXPECT_GT(predicted, 10 * classes.size());
}

}  // namespace
}  // namespace bakelight::mesomesh
