// Charts of larger surfaces: by way of a proxy, within a bounded effort.
#include "tools/atlas/charts/charting.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numeric>

#include "tests/support/rippled_ball.h"
#include "tests/unit/atlas/bodies.h"
#include "tools/atlas/charts/proxy.h"
#include "tools/atlas/flatten/injectivity.h"
#include "tools/atlas/make_atlas.h"

namespace bakelight::atlas {
namespace {

std::int64_t eulerCharacteristic(const Surface& surface) {
  std::int64_t inner_twice = 0, border = 0;
  for (const auto& neighbors : surface.neighbors)
    for (const std::int32_t other : neighbors) (other < 0 ? border : inner_twice) += 1;
  return static_cast<std::int64_t>(surface.positions.size()) - inner_twice / 2 - border +
         static_cast<std::int64_t>(surface.triangleCount());
}

ChartingOptions throughProxy() {
  ChartingOptions options;
  options.flattening.max_stretch = kFewCharts;
  options.flattening.small_area = 1.0 / 400;
  options.flattening.straightness = 5;
  options.proxy_triangles = 5000;
  return options;
}

TEST(Proxy, KeepsTopologyBordersAndShape) {
  for (const auto& mesh :
       {tests::rippledBall(8000), tests::torus(64, 40, 1, 0.4), tests::tube(60, 40, 1, 2)}) {
    const Surface surface = surfaceOf(mesh, "made.ply");
    const Proxy proxy = proxyOf(surface, surface.triangleCount() / 4);
    EXPECT_LE(proxy.surface.triangleCount(), surface.triangleCount() / 4 + 2);
    EXPECT_EQ(eulerCharacteristic(proxy.surface), eulerCharacteristic(surface));
    EXPECT_EQ(proxy.surface.border_edges, surface.border_edges);
    EXPECT_EQ(proxy.surface.non_manifold_edges, 0);
    EXPECT_EQ(proxy.surface.misoriented_edges, 0);
    EXPECT_NEAR(proxy.surface.area, 1, 0.12);
  }
}

TEST(Proxy, KeepsMarkedEdgesAndWhatHangsTogether) {
  // A slit along a torus's tube: it opens the surface but does not divide it.
  Surface surface = surfaceOf(tests::torus(64, 40, 1, 0.4), "made.ply");
  std::vector<std::array<std::uint32_t, 2>> slit;
  for (std::uint32_t j = 0; j < 40; ++j) slit.push_back({64 * j, 64 * ((j + 1) % 40)});
  ASSERT_EQ(cutEdges(surface, slit), 40);
  const Proxy proxy = proxyOf(surface, 1500);
  std::int64_t marked = 0;
  for (const auto& marks : proxy.surface.marks)
    for (const EdgeMark mark : marks) marked += mark == EdgeMark::kCut;
  EXPECT_EQ(marked, 80);  // from both sides
}

TEST(Proxy, HasATriangleNearEach) {
  const Surface surface = surfaceOf(tests::rippledBall(8000), "made.ply");
  const Proxy proxy = proxyOf(surface, 1000);
  const std::vector<std::int32_t> regions(surface.triangleCount(), 0);
  const auto all = nearestOfProxy(surface, regions, proxy);
  for (std::size_t t = 0; t < all.size(); ++t) {
    ASSERT_GE(all[t], 0);
    const double edge = std::sqrt(surface.area / 1000);
    EXPECT_LT((surface.corner(t, 0) - proxy.surface.corner(static_cast<std::size_t>(all[t]), 0)).norm(),
              8 * edge);
  }
}

TEST(MakeCharts, ByWayOfAProxyAreOneToOneWithinTheLimits) {
  const Surface surface = surfaceOf(tests::rippledBall(20000), "ball.ply");
  const ChartingOptions options = throughProxy();
  ChartingReport report;
  const std::vector<FlatPiece> pieces = makeCharts(surface, options, report);
  EXPECT_GT(report.proxy_triangles, 0);
  EXPECT_LE(report.proxy_triangles, 5002);
  EXPECT_LT(pieces.size(), 100u);
  std::vector<int> covered(surface.triangleCount(), 0);
  for (const FlatPiece& piece : pieces) {
    for (const std::uint32_t t : piece.chart.surface_triangles) ++covered[t];
    EXPECT_TRUE(isInjective(piece.chart, piece.plane));
    const double excess = piece.chart.area < options.flattening.small_area ? 4 : 1;
    EXPECT_LE(piece.stretch.l2(), 1 + excess * (kFewCharts - 1) + 1e-5);
  }
  EXPECT_THAT(covered, ::testing::Each(1));
}

TEST(MakeCharts, ByWayOfAProxyAreTheSameWithOneThread) {
  const Surface surface = surfaceOf(tests::rippledBall(12000), "ball.ply");
  const auto charts = [&] {
    ChartingOptions options = throughProxy();
    options.proxy_triangles = 4000;
    ChartingReport report;
    return makeCharts(surface, options, report);
  };
  const std::vector<FlatPiece> many = charts();
  const tbb::global_control one_only(tbb::global_control::max_allowed_parallelism, 1);
  const std::vector<FlatPiece> one = charts();
  ASSERT_EQ(one.size(), many.size());
  for (std::size_t c = 0; c < one.size(); ++c) {
    EXPECT_EQ(one[c].chart.surface_triangles, many[c].chart.surface_triangles);
    EXPECT_EQ(one[c].plane, many[c].plane);
  }
}

TEST(MakeCharts, TellsWhenTheEffortOfMergingEnds) {
  AtlasOptions options;
  options.resolution = 256;
  const formats::TriangleMesh mesh = tests::icosphere(4);
  const AtlasResult all = makeAtlas(mesh, {}, options, "ball.ply");
  EXPECT_TRUE(all.report.warnings.empty());
  EXPECT_FALSE(all.report.charting.is_merging_cut_short);
  options.merging_effort = 0.2;
  const AtlasResult some = makeAtlas(mesh, {}, options, "ball.ply");
  EXPECT_TRUE(some.report.charting.is_merging_cut_short);
  EXPECT_LE(some.report.charting.triangles_tried, static_cast<std::int64_t>(0.2 * 5120));
  EXPECT_THAT(some.report.warnings,
              ::testing::ElementsAre(::testing::HasSubstr("fewer charts may be possible")));
  EXPECT_GT(some.report.figures.charts, all.report.figures.charts);
}

TEST(MakeCharts, OfThousandsOfPartsTakeEachAsItIs) {
  const std::uint32_t count = 3000;
  formats::TriangleMesh mesh;
  for (std::uint32_t i = 0; i < count; ++i) {
    const float x = static_cast<float>(i % 60), y = static_cast<float>(i) / 60;
    for (const auto& [u, v] : {std::pair(0.0f, 0.0f), {0.5f, 0.0f}, {0.5f, 0.5f}, {0.0f, 0.5f}})
      mesh.positions.push_back({x + u, y + v, 0.1f * u * v});
    mesh.triangles.push_back({4 * i, 4 * i + 1, 4 * i + 2});
    mesh.triangles.push_back({4 * i, 4 * i + 2, 4 * i + 3});
  }
  const Surface surface = surfaceOf(mesh, "parts.ply");
  ChartingOptions options = throughProxy();
  options.proxy_triangles = 1000;
  ChartingReport report;
  EXPECT_EQ(makeCharts(surface, options, report).size(), count);
  EXPECT_EQ(report.proxy_triangles, 0);  // there is nothing to leave out
  EXPECT_EQ(report.merges_tried, 0);
}

}  // namespace
}  // namespace bakelight::atlas
