#include "tools/atlas/maps/geometry_maps.h"

#include <tbb/global_control.h>

#include <cmath>
#include <random>

#include "formats/error.h"
#include "tests/unit/atlas/map_reader.h"
#include "tests/unit/atlas/texture_quads.h"
#include "tools/atlas/check.h"
#include "tools/atlas/exact.h"
#include "tools/atlas/maps/texel_cover.h"

using namespace bakelight;
using namespace bakelight::tests;

namespace {

void expectFrame(const MapReader& maps, int i, int j) {
  const Vec3 normal = maps.vector("normal", i, j), tangent = maps.vector("tangent", i, j);
  EXPECT_NEAR(normal.norm(), 1, 1e-6);
  EXPECT_NEAR(tangent.norm(), 1, 1e-6);
  EXPECT_NEAR(normal.dot(tangent), 0, 1e-6);
  EXPECT_EQ(std::abs(maps.at("handedness", i, j)), 1);
}

TEST(GeometryMaps, ASquareIsWhereItsTexelsSay) {
  TriangleMesh mesh;
  addQuad(mesh, {0, 0, 3, 3}, {0.125F, 0.25F, 0.875F, 0.75F});  // 12 × 8 of 16 texels
  const MapReader maps = mapsOf(mesh, 16);
  EXPECT_EQ(maps.count(1), 96);
  EXPECT_EQ(maps.count(0), 160);
  maps.forEachTexel([&](int i, int j) {
    if (maps.coverage(i, j) == 0) {
      EXPECT_EQ(maps.at("chart", i, j), -1);
      EXPECT_EQ(maps.at("triangle", i, j), -1);
      EXPECT_EQ(maps.at("area", i, j), 0);
      return;
    }
    EXPECT_TRUE(i >= 2 && i < 14 && j >= 4 && j < 12);
    const Vec3 expected((i - 1.5) / 4, (j - 3.5) * 3 / 8, 0);
    EXPECT_LT((maps.vector("position", i, j) - expected).norm(), 1e-6);
    EXPECT_LT((maps.interpolatedPosition(mesh, i, j) - expected).norm(), 1e-6);
    EXPECT_NEAR(maps.at("area", i, j), 9 / 96.0, 1e-7);
    EXPECT_EQ(maps.vector("normal", i, j), Vec3(0, 0, 1));
    EXPECT_EQ(maps.vector("tangent", i, j), Vec3(1, 0, 0));
    EXPECT_EQ(maps.at("handedness", i, j), 1);
    EXPECT_EQ(maps.at("chart", i, j), 0);
  });
}

TEST(GeometryMaps, AMirroredChartHasTheOtherHand) {
  TriangleMesh mesh;
  addQuad(mesh, {0, 0, 1, 1}, {0, 0, 1, 1});
  for (auto& uv : mesh.texcoords) uv[0] = 1 - uv[0];
  const MapReader maps = mapsOf(mesh, 8);
  maps.forEachTexel([&](int i, int j) {
    EXPECT_EQ(maps.vector("tangent", i, j), Vec3(-1, 0, 0));
    EXPECT_EQ(maps.at("handedness", i, j), -1);
    EXPECT_LT((maps.vector("position", i, j) - Vec3(1 - (i + 0.5) / 8, (j + 0.5) / 8, 0)).norm(), 1e-6);
  });
}

TEST(GeometryMaps, AreasOfASphereAddUpAtAnyResolution) {
  for (const int subdivisions : {2, 4}) {
    const TriangleMesh mesh = flattenedSphere(subdivisions);
    const double area = surfaceArea(mesh);
    ASSERT_EQ(atlas::check(atlas::atlasOf(mesh), 64, "mesh").defects(), 0);
    for (const int resolution : {1, 7, 64, 300}) {
      const MapReader maps = mapsOf(mesh, resolution);
      EXPECT_NEAR(maps.totalArea(), area, 1e-6 * area) << resolution;
    }
    for (const int resolution : {7, 2048}) {
      const atlas::TexelCover cover = atlas::coverTexels(atlas::atlasOf(mesh), resolution);
      double sums[2] = {0, 0};
      for (std::size_t k = 0; k < cover.areas.size(); ++k)
        if (cover.charts[k] >= 0) sums[cover.charts[k]] += cover.areas[k];
      EXPECT_NEAR(sums[0] + sums[1], area, 1e-12 * area);
      if (resolution < 2048) continue;
      // Each chart for itself, where no texel is shared.
      double halves[2] = {0, 0};
      const atlas::Atlas charts = atlas::atlasOf(mesh);
      ASSERT_EQ(charts.chart_count, 2u);
      for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
        TriangleMesh one = mesh;
        one.triangles = {mesh.triangles[t]};
        halves[charts.triangle_charts[t]] += surfaceArea(one);
      }
      EXPECT_NEAR(sums[0], halves[0], 1e-12 * area);
      EXPECT_NEAR(sums[1], halves[1], 1e-12 * area);
    }
  }
}

TEST(GeometryMaps, PositionsLieOnTheTriangleAndFramesAreOrthonormal) {
  const TriangleMesh mesh = flattenedSphere(3);
  const MapReader maps = mapsOf(mesh, 128, 3);
  int covered = 0;
  maps.forEachTexel([&](int i, int j) {
    if (maps.coverage(i, j) == 0) return;
    ++covered;
    EXPECT_LT((maps.vector("position", i, j) - maps.interpolatedPosition(mesh, i, j)).norm(), 1e-6);
    expectFrame(maps, i, j);
    EXPECT_EQ(maps.at("handedness", i, j), 1);
    // Along growing u: where the neighbour to the right is, up to the map's curvature.
    if (maps.coverage(i, j) == 1 && i + 1 < 128 && maps.coverage(i + 1, j) == 1) {
      EXPECT_GT((maps.vector("position", i + 1, j) - maps.vector("position", i, j))
                    .normalized()
                    .dot(maps.vector("tangent", i, j)),
                0.9);
    }
  });
  EXPECT_GT(covered, 4000);
  EXPECT_GT(maps.count(3), 200);
}

// A grid whose corners lie on quarters of texels: many on centres, and edges through them.
TEST(GeometryMaps, EachCenterHasTheOneTriangleThatExactPredicatesSay) {
  constexpr int kSide = 16, kCells = 7;
  std::mt19937 engine(3);
  std::uniform_int_distribution<int> jitter(-2, 2);
  TriangleMesh mesh;
  const auto texture = [&](double s, double t) {
    const bool is_inner = s > 0 && s < 1 && t > 0 && t < 1;
    const Eigen::Vector2d moved(jitter(engine), jitter(engine));
    return Eigen::Vector2d((Eigen::Vector2d(1 + 2 * kCells * s, 1 + 2 * kCells * t) +
                            (is_inner ? Eigen::Vector2d(moved / 4) : Eigen::Vector2d(0, 0))) /
                           kSide);
  };
  addGrid(
      mesh, kCells, kCells, [](double s, double t) { return Vec3(s, t, s * t); }, texture);
  ASSERT_EQ(atlas::check(atlas::atlasOf(mesh), kSide, "mesh").flipped, 0);

  const MapReader maps = mapsOf(mesh, kSide);
  int on_edges = 0;
  maps.forEachTexel([&](int i, int j) {
    const atlas::Vec2 center = atlas::Vec2(i + 0.5, j + 0.5) / kSide;
    int claims = 0, triangle = -1;
    for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
      bool is_inside = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const formats::Float2 &from = mesh.texcoords[mesh.triangles[t][k]],
                              &to = mesh.texcoords[mesh.triangles[t][(k + 1) % 3]];
        const int side = atlas::orientation({from[0], from[1]}, {to[0], to[1]}, center);
        const bool owns_edge = to[1] < from[1] || (to[1] == from[1] && to[0] < from[0]);
        is_inside = is_inside && (side > 0 || (side == 0 && owns_edge));
        on_edges += side == 0;
      }
      if (is_inside) ++claims, triangle = static_cast<int>(t);
    }
    EXPECT_LE(claims, 1);
    EXPECT_EQ(maps.coverage(i, j) == 1, claims == 1);
    if (claims == 1) {
      EXPECT_EQ(maps.whole("triangle", i, j), triangle) << i << ", " << j;
    }
  });
  EXPECT_GT(on_edges, 100);
  EXPECT_EQ(maps.count(1), 14 * 14);
}

TEST(GeometryMaps, TexelsTouchedBesideTheirCentersTakeTheNearestPoint) {
  TriangleMesh mesh;
  addQuad(mesh, {0, 0, 1, 1}, {2.75F / 8, 2.75F / 8, 5.25F / 8, 5.25F / 8});
  const MapReader maps = mapsOf(mesh, 8);
  EXPECT_EQ(maps.count(1), 4);
  EXPECT_EQ(maps.count(2), 12);
  maps.forEachTexel([&](int i, int j) {
    if (maps.coverage(i, j) == 0) return;
    const Vec3 nearest(std::clamp((i - 2.25) / 2.5, 0.0, 1.0), std::clamp((j - 2.25) / 2.5, 0.0, 1.0), 0);
    EXPECT_LT((maps.vector("position", i, j) - nearest).norm(), 1e-6) << i << ", " << j;
    const double width = i == 2 || i == 5 ? 0.1 : 0.4, height = j == 2 || j == 5 ? 0.1 : 0.4;
    EXPECT_NEAR(maps.at("area", i, j), width * height, 1e-6);
  });
}

TEST(GeometryMaps, ASharedTexelGoesToItsCenterElseToTheLargerArea) {
  TriangleMesh mesh;
  addQuad(mesh, {0, 0, 1, 1}, {0, 0, 2.25F / 8, 1 / 8.F});            // a quarter of texel 2
  addQuad(mesh, {0, 2, 1, 3}, {2.625F / 8, 0, 5.375F / 8, 1 / 8.F});  // three eighths of it
  addQuad(mesh, {0, 4, 0.25F, 4.25F},
          {5.375F / 8, 0, 5.625F / 8, 1 / 8.F});  // less of texel 5, but its centre
  const MapReader maps = mapsOf(mesh, 8);
  EXPECT_EQ(maps.coverage(2, 0), 2);
  EXPECT_EQ(maps.at("chart", 2, 0), 1);
  EXPECT_NEAR(maps.at("area", 2, 0), 0.25 / 2.25 + 0.375 / 2.75, 1e-6);
  EXPECT_EQ(maps.coverage(5, 0), 1);
  EXPECT_EQ(maps.at("chart", 5, 0), 2);
  EXPECT_NEAR(maps.totalArea(), 2 + 1 / 16.0, 1e-6);
}

TEST(GeometryMaps, TrianglesBelowATexelAndSliversLoseNoArea) {
  TriangleMesh mesh;
  addGrid(
      mesh, 40, 40, [](double s, double t) { return Vec3(s, t, 0); },
      [](double s, double t) { return Eigen::Vector2d(0.3 + 0.2 * s, 0.3 + 0.2 * t); });
  EXPECT_NEAR(mapsOf(mesh, 8).totalArea(), 1, 1e-6);

  TriangleMesh sliver;
  sliver.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  sliver.texcoords = {{0.01F, 0.01F}, {0.99F, 0.97F}, {0.99F, 0.9700001F}};
  sliver.triangles = {{0, 1, 2}};
  const MapReader maps = mapsOf(sliver, 64);
  EXPECT_NEAR(maps.totalArea(), 0.5, 1e-6);
  EXPECT_GT(maps.count(2), 60);
  maps.forEachTexel([&](int i, int j) {
    if (maps.coverage(i, j) != 0) expectFrame(maps, i, j);
  });
}

TEST(GeometryMaps, ThreadsDoNotChangeABit) {
  const atlas::Atlas charts = atlas::atlasOf(flattenedSphere(4));
  const auto mapsWith = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return atlas::geometryMaps(charts, {200, 3}, "mesh");
  };
  const formats::Image one = mapsWith(1), many = mapsWith(7);
  EXPECT_EQ(one.values, many.values);
  EXPECT_EQ(one.channel_names.size(), 16u);
}

TEST(GeometryMaps, CoordinatesOutsideAreToldWithTheirFace) {
  TriangleMesh mesh;
  addQuad(mesh, {0, 0, 1, 1}, {0, 0, 1, 1});
  mesh.texcoords[3][1] = 1.5F;
  try {
    mapsOf(mesh, 8);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.place().file, "mesh");
    EXPECT_EQ(error.place().element, "face 1");
  }
}

}  // namespace
