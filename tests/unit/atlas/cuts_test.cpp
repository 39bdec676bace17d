#include "tools/atlas/charts/cuts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/json.h"
#include "tests/unit/atlas/flat_shapes.h"

namespace bakelight::atlas {
namespace {

using formats::Json;
using testing::HasSubstr;
using tests::TriangleMesh;

constexpr int kSide = 10;

// A flat square of 10 × 10 cells from (100, 0, 0) to (110, 10, 0), each halved from lower left to upper
// right.
TriangleMesh grid() {
  TriangleMesh mesh;
  for (int y = 0; y <= kSide; ++y)
    for (int x = 0; x <= kSide; ++x)
      mesh.positions.push_back({100 + static_cast<float>(x), static_cast<float>(y), 0});
  const auto at = [](int x, int y) { return static_cast<std::uint32_t>(y * (kSide + 1) + x); };
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      mesh.triangles.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      mesh.triangles.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  return mesh;
}

std::uint32_t vertexAt(int x, int y) {
  return static_cast<std::uint32_t>(y * (kSide + 1) + x);
}

// The edges that are cut, by their vertices; both sides have to agree.
std::vector<std::array<std::uint32_t, 2>> cutEdgesOf(const Surface& surface) {
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (std::size_t t = 0; t < surface.triangleCount(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      if (surface.marks[t][k] != EdgeMark::kCut) continue;
      const std::uint32_t a = surface.triangles[t][k], b = surface.triangles[t][(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b)});
      const std::int32_t other = surface.neighbors[t][k];
      if (other >= 0) {
        const auto& theirs = surface.neighbors[other];
        const auto back =
            std::find(theirs.begin(), theirs.end(), static_cast<std::int32_t>(t)) - theirs.begin();
        EXPECT_EQ(surface.marks[other][back], EdgeMark::kCut);
      }
    }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

std::string errorOf(const Json& json) {
  Surface surface = surfaceOf(grid(), "grid.ply");
  try {
    applyCuts(surface, cutsFromJson(json, "cuts.json"), "cuts.json");
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    EXPECT_EQ(error.place().file, "cuts.json");
    return error.what();
  }
  return "no error";
}

TEST(Cuts, LinesOfVerticesAndPositionsCutTheSameEdges) {
  const std::vector<std::array<std::uint32_t, 2>> expected = {{vertexAt(3, 0), vertexAt(3, 1)},
                                                              {vertexAt(3, 1), vertexAt(4, 2)}};
  Surface by_number = surfaceOf(grid(), "grid.ply"), by_position = by_number;
  const Json numbers = {{"cuts", {{vertexAt(3, 0), vertexAt(3, 1), vertexAt(4, 2)}}}};
  EXPECT_EQ(applyCuts(by_number, cutsFromJson(numbers, ""), "").edges, 2);
  EXPECT_EQ(cutEdgesOf(by_number), expected);
  const Json positions = {{"cuts", {{{103, 0.1, 0}, {103.05, 0.9, 0}, {104, 2, 0.01}}}}};
  EXPECT_EQ(applyCuts(by_position, cutsFromJson(positions, ""), "").edges, 2);
  EXPECT_EQ(cutEdgesOf(by_position), expected);
}

TEST(Cuts, PointsApartAreJoinedByTheShortestPath) {
  Surface surface = surfaceOf(grid(), "grid.ply");
  // Along the diagonals, which only lead to the upper right: √2 each, against 2 around the cell.
  const Json diagonal = {{"cuts", {{vertexAt(2, 2), vertexAt(7, 7)}}}};
  EXPECT_EQ(applyCuts(surface, cutsFromJson(diagonal, ""), "").edges, 5);
  for (const auto& [a, b] : cutEdgesOf(surface)) EXPECT_EQ(b - a, kSide + 2u);
  // From border to border, so that the square falls in two.
  const Json across = {{"cuts", {{vertexAt(0, 4), vertexAt(10, 4)}}}};
  Surface divided = surfaceOf(grid(), "grid.ply");
  EXPECT_EQ(applyCuts(divided, cutsFromJson(across, ""), "").edges, 10);
  const std::vector<std::int32_t> one_label(divided.triangleCount(), 0);
  const auto parts = connectedParts(divided, one_label);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].size(), 80u);
  EXPECT_EQ(parts[1].size(), 120u);
}

TEST(Cuts, ThePathIsShortInLengthAndNotInEdges) {
  // Around the rim of a tall cone and not over its tip, which two edges would do.
  Surface surface = surfaceOf(tests::fan(12, 10), "cone.ply");
  const Json json = {{"cuts", {{1, 4}}}};
  EXPECT_EQ(applyCuts(surface, cutsFromJson(json, ""), "").edges, 3);
  EXPECT_EQ(cutEdgesOf(surface), (std::vector<std::array<std::uint32_t, 2>>{{1, 2}, {2, 3}, {3, 4}}));
}

TEST(Cuts, AnEdgeIsCountedOnceAndAPointTwiceIsNoEdge) {
  Surface surface = surfaceOf(grid(), "grid.ply");
  const Json json = {{"cuts", {{5, 6, 6, 5}, {6, 5}}}};
  EXPECT_EQ(applyCuts(surface, cutsFromJson(json, ""), "").edges, 1);
}

TEST(Cuts, CornersArePlaces) {
  Surface surface = surfaceOf(grid(), "grid.ply");
  const Json json = {{"corners", {vertexAt(10, 10), {100, 0, 0}, vertexAt(0, 0), {110, 0, 0}}}};
  const AppliedCuts applied = applyCuts(surface, cutsFromJson(json, ""), "");
  EXPECT_EQ(applied.corner_places,
            (std::vector<std::uint32_t>{vertexAt(0, 0), vertexAt(10, 0), vertexAt(10, 10)}));
  EXPECT_EQ(applied.edges, 0);
  EXPECT_TRUE(cutEdgesOf(surface).empty());
}

TEST(Cuts, CopiesOfAVertexAreOnePlace) {
  TriangleMesh mesh = grid();
  mesh.positions.push_back(mesh.positions[0]);
  mesh.triangles[1][0] = static_cast<std::uint32_t>(mesh.positions.size() - 1);
  Surface surface = surfaceOf(mesh, "grid.ply");
  const Json json = {{"cuts", {{mesh.positions.size() - 1, vertexAt(1, 1)}}}};
  EXPECT_EQ(applyCuts(surface, cutsFromJson(json, ""), "").edges, 1);
  EXPECT_EQ(cutEdgesOf(surface).size(), 1u);
}

TEST(Cuts, BadFilesNameTheirPlace) {
  EXPECT_EQ(errorOf(Json::object()), "no error");
  EXPECT_THAT(errorOf(Json::array()), HasSubstr("JSON object"));
  EXPECT_THAT(errorOf({{"corner", {1}}}), HasSubstr("/corner: unknown key \"corner\""));
  EXPECT_THAT(errorOf({{"corner", {1}}}), HasSubstr("write \"corners\""));
  EXPECT_THAT(errorOf({{"cuts", 3}}), HasSubstr("at /cuts: it is a number"));
  EXPECT_THAT(errorOf({{"cuts", {1, 2}}}), HasSubstr("at /cuts/0: it is a number"));
  EXPECT_THAT(errorOf({{"cuts", Json::array({Json::array({1})})}}), HasSubstr("at /cuts/0: has 1 points"));
  EXPECT_THAT(errorOf({{"cuts", {{1, 2}, {3, "a"}}}}), HasSubstr("at /cuts/1/1: \"a\" is no point"));
  EXPECT_THAT(errorOf({{"cuts", {{1, 2.5}}}}), HasSubstr("at /cuts/0/1: 2.5 is no point"));
  EXPECT_THAT(errorOf({{"cuts", {{1, {0, 0}}}}}), HasSubstr("at /cuts/0/1: [0,0] is no point"));
  EXPECT_THAT(errorOf({{"corners", {0, -1}}}), HasSubstr("at /corners/1: -1 is no vertex"));
  EXPECT_THAT(errorOf({{"corners", {0, 5000000000}}}), HasSubstr("at /corners/1: 5000000000 is no vertex"));
  EXPECT_THAT(errorOf({{"cuts", {{1, 121}}}}), HasSubstr("at /cuts/0/1: vertex 121 does not exist"));
  EXPECT_THAT(errorOf({{"cuts", {{1, {105, 5, 0.2}}}}}),
              HasSubstr("at /cuts/0/1: the nearest vertex is 1.4"));
  EXPECT_THAT(errorOf({{"corners", {{0, 0, 0}}}}), HasSubstr("at /corners/0: the nearest vertex is"));
}

TEST(Cuts, PartsThatDoNotHangTogetherHaveNoPath) {
  TriangleMesh mesh = grid(), other = grid();
  for (auto& position : other.positions) position[2] = 50;
  tests::append(mesh, other);
  mesh.positions.push_back({105, 5, 25});  // of no triangle
  Surface surface = surfaceOf(mesh, "grid.ply");
  const auto errorOfCut = [&](const Json& json) -> std::string {
    try {
      applyCuts(surface, cutsFromJson(json, "cuts.json"), "cuts.json");
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_THAT(errorOfCut({{"cuts", {{0, 1, 121}}}}), HasSubstr("at /cuts/0/2: no path"));
  EXPECT_THAT(errorOfCut({{"corners", {242}}}),
              HasSubstr("at /corners/0: vertex 242 belongs to no triangle"));
  EXPECT_TRUE(cutEdgesOf(surface).empty());  // nothing is half done
}

TEST(Cuts, MarkedEdgesThatNoTriangleHasAreCounted) {
  Surface surface = surfaceOf(grid(), "grid.ply");
  const std::vector<std::array<std::uint32_t, 2>> edges = {{0, 1}, {1, 0}, {1, 2}, {0, 5}, {7, 7}};
  const MarkedEdges marked = cutMarkedEdges(surface, edges);
  EXPECT_EQ(marked.cut, 2);
  EXPECT_EQ(marked.unknown, 2);
  EXPECT_EQ(cutEdgesOf(surface), (std::vector<std::array<std::uint32_t, 2>>{{0, 1}, {1, 2}}));
}

}  // namespace
}  // namespace bakelight::atlas
