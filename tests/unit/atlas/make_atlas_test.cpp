#include "tools/atlas/make_atlas.h"

#include <tbb/global_control.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "bodies.h"
#include "flat_shapes.h"
#include "formats/error.h"
#include "tools/atlas/flatten/float_rounding.h"

namespace bakelight::atlas {
namespace {

using formats::TriangleMesh;

AtlasOptions small(Parameterization parameterization = Parameterization::kFree) {
  AtlasOptions options;
  options.parameterization = parameterization;
  options.resolution = 256;
  if (parameterization == Parameterization::kConvex) options.max_stretch = 1.25;
  return options;
}

// What holds for every atlas. Returns it.
AtlasResult expectValid(const TriangleMesh& mesh, const AtlasOptions& options, const UserCuts& cuts = {}) {
  AtlasResult result = makeAtlas(mesh, cuts, options, "made.ply");
  const AtlasFigures& figures = result.report.figures;
  EXPECT_EQ(figures.flipped, 0);
  EXPECT_EQ(figures.collapsed, 0);
  EXPECT_EQ(figures.overlapping_texels, 0);
  EXPECT_EQ(figures.crossing_edges, 0);
  EXPECT_EQ(figures.outside, 0);
  EXPECT_GE(figures.smallest_gutter, options.gutter + 2 * options.border);
  EXPECT_EQ(figures.charts, result.atlas.chart_count);
  EXPECT_EQ(result.atlas.mesh.triangleCount(), mesh.triangleCount() - result.report.degenerate_triangles);
  // The very same triangles at the very same places.
  for (std::size_t t = 0; t < result.atlas.mesh.triangleCount(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t source = mesh.triangles[result.source_triangles[t]][k],
                          vertex = result.atlas.mesh.triangles[t][k];
      EXPECT_EQ(result.source_vertices[vertex], source);
      EXPECT_EQ(result.atlas.mesh.positions[vertex], mesh.positions[source]);
    }
  return result;
}

TEST(MakeAtlas, OfABallIsValidAndFull) {
  const AtlasResult result = expectValid(tests::icosphere(4), small());
  EXPECT_LT(result.report.figures.l2_stretch, 1.02);
  EXPECT_LE(result.report.figures.worst_chart_l2, 1.03 + 1e-6);
  EXPECT_GT(result.report.figures.utilisation, 0.5);
  EXPECT_LT(result.report.figures.charts, 40);
}

TEST(MakeAtlas, MaterialsOfTrianglesSurvive) {
  TriangleMesh ball = tests::icosphere(2);
  ball.triangles.insert(ball.triangles.begin() + 5, {0, 0, 1});  // without area: left out
  for (std::uint32_t t = 0; t < ball.triangleCount(); ++t) ball.triangle_materials.push_back(t % 3);
  ball.material_names = {"a", "", "c"};
  const AtlasResult made = expectValid(ball, small());
  EXPECT_EQ(made.atlas.mesh.material_names, ball.material_names);
  ASSERT_EQ(made.atlas.mesh.triangle_materials.size(), ball.triangleCount() - 1);
  for (std::size_t t = 0; t < made.source_triangles.size(); ++t)
    EXPECT_EQ(made.atlas.mesh.triangle_materials[t], made.source_triangles[t] % 3);
  const AtlasResult own = ownAtlas(made.atlas.mesh, small(), "own.ply");
  EXPECT_EQ(own.atlas.mesh.triangle_materials, made.atlas.mesh.triangle_materials);
  EXPECT_EQ(own.atlas.mesh.material_names, ball.material_names);
}

TEST(MakeAtlas, TightensStretchOnRequest) {
  AtlasOptions options = small();
  options.max_stretch = 1.002;
  const AtlasResult result = expectValid(tests::icosphere(4), options);
  EXPECT_LE(result.report.figures.worst_chart_l2, 1.002 + 1e-6);
}

TEST(MakeAtlas, TakesClosedBodiesOfAnyGenus) {
  expectValid(tests::torus(60, 24, 2, 0.7), small());
  const TriangleMesh five = tests::slabWithHoles(5, 4, 8);
  ASSERT_EQ(tests::wholeChart(five).euler_characteristic, 2 - 2 * 5);
  for (const auto way : {Parameterization::kFree, Parameterization::kConvex, Parameterization::kProjection})
    expectValid(five, small(way));
}

TEST(MakeAtlas, TakesAMoebiusStrip) {
  const AtlasResult result = expectValid(tests::moebiusStrip(80, 6), small());
  EXPECT_EQ(result.report.misoriented_edges, 6);
  ASSERT_EQ(result.report.warnings.size(), 1u);
  EXPECT_THAT(result.report.warnings[0], ::testing::HasSubstr("6 edges whose triangles face opposite ways"));
}

TEST(MakeAtlas, TakesConesFlatAndSharp) {
  for (const double height : {0.1, 1.0, 30.0})
    for (const auto way : {Parameterization::kFree, Parameterization::kConvex, Parameterization::kProjection})
      expectValid(tests::fan(1000, height), small(way));
}

TEST(MakeAtlas, TakesOneTriangle) {
  for (const auto way : {Parameterization::kFree, Parameterization::kConvex, Parameterization::kProjection}) {
    const AtlasResult result = expectValid(tests::confetti(1), small(way));
    EXPECT_EQ(result.report.figures.charts, 1);
    EXPECT_NEAR(result.report.figures.l2_stretch, 1, 1e-5);
  }
}

TEST(MakeAtlas, DividesWhatWouldLieOnItself) {
  AtlasOptions options = small();
  options.straightness = 0;
  const AtlasResult result = expectValid(tests::spiralRibbon(3, 240), options);
  EXPECT_GE(result.report.figures.charts, 3);
  EXPECT_NEAR(result.report.figures.l2_stretch, 1, 1e-3);
}

TEST(MakeAtlas, TakesAHundredThousandComponents) {
  AtlasOptions options = small();
  options.resolution = 1024;
  const AtlasResult result = expectValid(tests::confetti(100000), options);
  EXPECT_EQ(result.report.figures.charts, 100000);
}

TEST(Charting, DoesNotFallToPiecesWhereTheSurfaceIsRough) {
  TriangleMesh mesh = tests::icosphere(4);
  std::uint32_t state = 1;
  for (auto& p : mesh.positions) {
    state = state * 1664525u + 1013904223u;
    const float radius = 0.93f + 0.14f * static_cast<float>(state >> 8) / 16777216.0f;
    for (float& x : p) x *= radius;
  }
  const Surface surface = surfaceOf(mesh, "rough.ply");
  const auto chartsWith = [&](double small_area) {
    ChartingOptions options;
    // Less than the neighbourhood of a vertex has, but not less than a quarter of that.
    options.flattening.max_stretch = 1.01;
    options.flattening.small_area = small_area;
    ChartingReport report;
    return makeCharts(surface, options, report).size();
  };
  const std::size_t strict = chartsWith(0), lenient = chartsWith(1.0 / 100);
  std::printf("%zu charts, %zu with lenience for small ones\n", strict, lenient);
  EXPECT_LT(lenient, strict / 2);
}

TEST(MakeAtlas, SaysWhatResolutionIsNeeded) {
  try {
    makeAtlas(tests::confetti(10000), {}, small(), "confetti.ply");
    FAIL() << "10,000 charts with gutters of 2 fit 256 × 256 texels?";
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    EXPECT_EQ(error.place().file, "confetti.ply");
    EXPECT_THAT(error.paragraph(), ::testing::HasSubstr("10000"));
    EXPECT_THAT(error.paragraph(), ::testing::HasSubstr("resolution"));
  }
}

TEST(MakeAtlas, RespectsCreases) {
  // A box: six flat sides.
  const AtlasResult result = expectValid(tests::slabWithHoles(0, 6, 0), small());
  EXPECT_EQ(result.report.figures.charts, 6);
  EXPECT_NEAR(result.report.figures.l2_stretch, 1, 1e-6);
  const TriangleMesh& mesh = result.atlas.mesh;
  std::map<std::uint32_t, std::set<std::array<int, 3>>> normals;
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
    const auto corner = [&](std::size_t k) { return transport::vec3(mesh.positions[mesh.triangles[t][k]]); };
    const Vec3 n = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    normals[result.atlas.triangle_charts[t]].insert({static_cast<int>(std::lround(n.x())),
                                                     static_cast<int>(std::lround(n.y())),
                                                     static_cast<int>(std::lround(n.z()))});
  }
  for (const auto& [chart, ways] : normals) EXPECT_EQ(ways.size(), 1u) << chart;
}

TEST(MakeAtlas, ProjectsChartsOfSimilarNormals) {
  AtlasOptions options = small(Parameterization::kProjection);
  options.border = 4;
  const TriangleMesh mesh = tests::icosphere(4);
  const AtlasResult result = expectValid(mesh, options);
  // Orthographic: within 30° of the mean normal no length shrinks to less than cos 30°, none grows.
  EXPECT_LT(result.report.figures.mean_anisotropy, 1 / std::cos(std::numbers::pi / 6));
  // All are within 30° of the line of sight, so no two are more than 60° apart.
  std::map<std::uint32_t, std::vector<Vec3>> normals;
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
    const auto corner = [&](std::size_t k) {
      return transport::vec3(mesh.positions[mesh.triangles[result.source_triangles[t]][k]]);
    };
    normals[result.atlas.triangle_charts[t]].push_back(
        (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized());
  }
  EXPECT_LT(normals.size(), 60u);
  for (const auto& [chart, of_chart] : normals)
    for (const Vec3& a : of_chart)
      for (const Vec3& b : of_chart) EXPECT_GE(a.dot(b), 0.5 - 1e-9) << chart;
}

TEST(MakeAtlas, ChartsAreWhatTheCutsLeave) {
  // A tube, cut open along one line: one chart, rolled out without stretch.
  const TriangleMesh mesh = tests::tube(40, 10, 1, 2);
  AtlasOptions options = small();
  options.cuts_only = true;
  UserCuts cuts;
  cuts.cuts.lines = {{CutPoint(0u), CutPoint(400u)}};
  cuts.cuts_file = "cuts.json";
  const AtlasResult result = expectValid(mesh, options, cuts);
  EXPECT_EQ(result.report.cut_edges, 10);
  EXPECT_EQ(result.report.figures.charts, 1);
  EXPECT_NEAR(result.report.figures.l2_stretch, 1, 1e-6);
  // The same by edges that are marked in the mesh.
  UserCuts marked;
  for (std::uint32_t j = 0; j < 10; ++j) marked.marked_edges.push_back({40 * j, 40 * (j + 1)});
  EXPECT_EQ(makeAtlas(mesh, marked, options, "made.ply").atlas.mesh.texcoords, result.atlas.mesh.texcoords);
}

TEST(MakeAtlas, KeepsNormalsAndColorsOfEachCorner) {
  TriangleMesh mesh = tests::icosphere(2);
  for (const auto& n : mesh.normals) mesh.colors.push_back({(n[0] + 1) / 2, (n[1] + 1) / 2, (n[2] + 1) / 2});
  const AtlasResult result = expectValid(mesh, small());
  for (std::size_t v = 0; v < result.atlas.mesh.vertexCount(); ++v) {
    EXPECT_EQ(result.atlas.mesh.normals[v], mesh.normals[result.source_vertices[v]]);
    EXPECT_EQ(result.atlas.mesh.colors[v], mesh.colors[result.source_vertices[v]]);
  }
}

TEST(MakeAtlas, LeavesOutTrianglesWithoutAreaAndSaysSo) {
  TriangleMesh mesh = tests::icosphere(1);
  mesh.triangles.insert(mesh.triangles.begin() + 5, {3, 3, 4});
  const AtlasResult result = expectValid(mesh, small());
  EXPECT_EQ(result.report.degenerate_triangles, 1);
  EXPECT_EQ(result.source_triangles[5], 6u);
  ASSERT_EQ(result.report.warnings.size(), 1u);
}

TEST(MakeAtlas, IsTheSameWithOneThread) {
  const TriangleMesh mesh = tests::slabWithHoles(2, 5, 6);
  const AtlasResult many = makeAtlas(mesh, {}, small(), "made.ply");
  const tbb::global_control one_only(tbb::global_control::max_allowed_parallelism, 1);
  const AtlasResult one = makeAtlas(mesh, {}, small(), "made.ply");
  EXPECT_EQ(one.atlas.mesh.texcoords, many.atlas.mesh.texcoords);
  EXPECT_EQ(one.atlas.triangle_charts, many.atlas.triangle_charts);
}

TEST(OwnAtlas, TakesTheMeshAsItIs) {
  const TriangleMesh mesh = makeAtlas(tests::icosphere(3), {}, small(), "made.ply").atlas.mesh;
  const AtlasResult own = ownAtlas(mesh, small(), "own.ply");
  EXPECT_EQ(own.atlas.mesh.texcoords, mesh.texcoords);
  EXPECT_EQ(own.atlas.mesh.triangles, mesh.triangles);
}

TEST(OwnAtlas, RefusesWhatIsNoAtlas) {
  TriangleMesh mesh = makeAtlas(tests::icosphere(3), {}, small(), "made.ply").atlas.mesh;
  AtlasOptions options = small();
  options.gutter = 60;
  EXPECT_THROW(ownAtlas(mesh, options, "own.ply"), Error);
  for (auto& t : mesh.texcoords) t = {t[0] / 2, t[1] / 2};
  std::swap(mesh.texcoords[0], mesh.texcoords[50]);
  EXPECT_THROW(ownAtlas(mesh, small(), "own.ply"), Error);
  mesh.texcoords.clear();
  EXPECT_THROW(ownAtlas(mesh, small(), "own.ply"), Error);
}

TEST(FloatRounding, TurnsFlippedTrianglesBack) {
  // A triangle flatter than the spacing of floats, amid others.
  std::vector<formats::Float2> texcoords = {
      {0.75f, 0.75f}, {0.8125f, 0.8125f}, {0.78125f, 0.78125f}, {0.75f, 0.8125f}};
  const std::vector<formats::Triangle> triangles = {{0, 1, 2}, {0, 2, 3}, {2, 1, 3}};
  EXPECT_GT(nudgeFlipped(triangles, texcoords), 0);
  for (const auto& t : triangles) {
    const auto at = [&](std::size_t k) { return Vec2(texcoords[t[k]][0], texcoords[t[k]][1]); };
    EXPECT_GT(crossOf(at(0), at(1), at(2)), 0);  // exact for these few bits
  }
  EXPECT_EQ(nudgeFlipped(triangles, texcoords), 0);
}

}  // namespace
}  // namespace bakelight::atlas
