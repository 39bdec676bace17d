#include <cmath>
#include <numbers>

#include "tests/unit/atlas/map_reader.h"
#include "tools/atlas/maps/geometry_maps.h"

using namespace bakelight;
using namespace bakelight::tests;
using Eigen::Vector2d;

namespace {

constexpr int kSide = 64;
constexpr double kTexel = 0.1;  // length on the surface

// A chart in the plane: texels ↔ the sheet, turned by quarters.
struct Chart {
  Vector2d place, texel;  // of the lower left corner: on the sheet, in the atlas
  Vector2d u;             // where u grows on the sheet, unit length

  Vector2d v() const { return {-u.y(), u.x()}; }
  Vector2d textureOf(const Vector2d& p) const {
    const Vector2d way = (p - place) / kTexel;
    return (texel + Vector2d(way.dot(u), way.dot(v()))) / kSide;
  }
  Vector2d placeOf(double i, double j) const {
    return place + kTexel * ((i - texel.x()) * u + (j - texel.y()) * v());
  }
};

// From `low` to `high` of the sheet z = 0.
void addSheet(TriangleMesh& mesh, const Vector2d& low, const Vector2d& high, const Chart& chart) {
  const auto at = [=](double s, double t) {
    return Vector2d(low.x() + s * (high.x() - low.x()), low.y() + t * (high.y() - low.y()));
  };
  addGrid(
      mesh, 5, 3, [&](double s, double t) { return Vec3(at(s, t).x(), at(s, t).y(), 0); },
      [&](double s, double t) { return chart.textureOf(at(s, t)); });
}

// Border texels continue the chart's own map, as far as the sheet reaches.
int expectAffineBorders(const TriangleMesh& mesh, const std::vector<Chart>& charts, const Vector2d& high,
                        int border) {
  const MapReader maps = mapsOf(mesh, kSide, border);
  int borders = 0;
  maps.forEachTexel([&](int i, int j) {
    if (maps.coverage(i, j) != 3) return;
    ++borders;
    const Chart& chart = charts[maps.whole("chart", i, j)];
    const Vector2d expected = chart.placeOf(i + 0.5, j + 0.5);
    EXPECT_LT((maps.vector("position", i, j) - Vec3(expected.x(), expected.y(), 0)).norm(), 1e-5)
        << i << ", " << j;
    EXPECT_LT((maps.vector("position", i, j) - maps.interpolatedPosition(mesh, i, j)).norm(), 1e-5);
    EXPECT_LT((maps.vector("tangent", i, j) - Vec3(chart.u.x(), chart.u.y(), 0)).norm(), 1e-5);
    EXPECT_EQ(maps.at("handedness", i, j), 1);
    EXPECT_EQ(maps.at("area", i, j), 0);
    EXPECT_TRUE(expected.x() > 0 && expected.y() > 0 && expected.x() < high.x() && expected.y() < high.y());
  });
  return borders;
}

TEST(GeometryMapsBorder, ASheetInTwoChartsGoesOnBeyondTheCut) {
  const std::vector<Chart> charts = {{{0, 0}, {8, 10}, {1, 0}}, {{1.3, 0}, {50, 20}, {0, 1}}};
  TriangleMesh mesh;
  addSheet(mesh, {0, 0}, {1.3, 1}, charts[0]);
  addSheet(mesh, {1.3, 0}, {2.6, 1}, charts[1]);
  // Each cut is ten texels long, and nothing lies beyond the other borders.
  EXPECT_EQ(expectAffineBorders(mesh, charts, {2.6, 1}, 3), 2 * 3 * 10);
  EXPECT_EQ(expectAffineBorders(mesh, charts, {2.6, 1}, 1), 2 * 1 * 10);
}

TEST(GeometryMapsBorder, AroundACornerTheSheetGoesOn) {
  const std::vector<Chart> charts = {{{0, 0}, {5, 5}, {1, 0}},
                                     {{1, 0}, {30, 5}, {1, 0}},
                                     {{0, 1}, {20, 40}, {0, -1}},
                                     {{1, 1}, {55, 55}, {-1, 0}}};
  TriangleMesh mesh;
  addSheet(mesh, {0, 0}, {1, 1}, charts[0]);
  addSheet(mesh, {1, 0}, {2, 1}, charts[1]);
  addSheet(mesh, {0, 1}, {1, 2}, charts[2]);
  addSheet(mesh, {1, 1}, {2, 2}, charts[3]);
  // Two sides of ten texels and the square between them.
  EXPECT_EQ(expectAffineBorders(mesh, charts, {2, 2}, 3), 4 * (3 * 10 + 3 * 10 + 9));
}

// A chart of one thin triangle in a sheet with a hole for it: beyond its sharp corner, too, the sheet goes
// on.
TEST(GeometryMapsBorder, BeyondASharpCornerTheSheetGoesOn) {
  const std::vector<Chart> charts = {{{1, 1.5}, {5.3, 8.2}, {1, 0}}, {{0, 0}, {20, 20}, {1, 0}}};
  const std::vector<Vector2d> corners = {{1, 1.5}, {3, 2}, {1, 2}, {0, 0}, {4, 0}, {4, 4}, {0, 4}};
  TriangleMesh mesh;
  for (const Chart& chart : charts)
    for (const Vector2d& p : corners) {
      mesh.positions.push_back(float3({p.x(), p.y(), 0}));
      const Vector2d uv = chart.textureOf(p);
      mesh.texcoords.push_back({static_cast<float>(uv.x()), static_cast<float>(uv.y())});
    }
  mesh.triangles = {{0, 1, 2},   {10, 11, 7}, {11, 8, 7},  {11, 12, 8},
                    {12, 13, 8}, {13, 9, 8},  {13, 10, 9}, {10, 7, 9}};
  EXPECT_GT(expectAffineBorders(mesh, charts, {4, 4}, 3), 150);

  const MapReader maps = mapsOf(mesh, kSide, 3);
  const auto isNearChart = [&](int i, int j) {
    for (int y = std::max(j - 3, 0); y <= j + 3; ++y)
      for (int x = std::max(i - 3, 0); x <= i + 3; ++x)
        if (maps.coverage(x, y) % 3 != 0 && maps.whole("chart", x, y) == 0) return true;
    return false;
  };
  for (int j = 0; j < 18; ++j)
    for (int i = 0; i < kSide - 3; ++i) {
      if (maps.coverage(i, j) % 3 != 0) continue;
      EXPECT_EQ(maps.coverage(i, j) == 3, isNearChart(i, j)) << i << ", " << j;
    }
}

// Beyond the cut of an unrolled cylinder comes its other end: to the left of 0 what is left of the end.
TEST(GeometryMapsBorder, ACylinderGoesOnAroundItsCut) {
  constexpr int kSides = 40, kWide = 42;
  const double side_length = kWide * kTexel / kSides;
  const double radius = side_length / 2 / std::sin(std::numbers::pi / kSides);
  const auto unrolled = [&](double x, double y) {  // on the prism, x once around
    const double turns = x / (kWide * kTexel), sides = (turns - std::floor(turns)) * kSides;
    const auto corner = [&](double k) {
      const double angle = 2 * std::numbers::pi * k / kSides;
      return Vec3(radius * std::cos(angle), y, -radius * std::sin(angle));
    };
    const double share = sides - std::floor(sides);
    return Vec3((1 - share) * corner(std::floor(sides)) + share * corner(std::floor(sides) + 1));
  };
  TriangleMesh mesh;
  addGrid(
      mesh, kSides, 3, [&](double s, double t) { return unrolled(s == 1 ? 0 : s * kWide * kTexel, 2 * t); },
      [&](double s, double t) { return Vector2d((10 + kWide * s) / kSide, (20 + 20 * t) / kSide); });
  const MapReader maps = mapsOf(mesh, kSide, 4);
  EXPECT_EQ(maps.count(1), kWide * 20);
  EXPECT_EQ(maps.count(3), 2 * 4 * 20);
  maps.forEachTexel([&](int i, int j) {
    if (maps.coverage(i, j) == 0) return;
    const double x = (i + 0.5 - 10) * kTexel, y = (j + 0.5 - 20) * kTexel;
    EXPECT_LT((maps.vector("position", i, j) - unrolled(x, y)).norm(), 2e-5) << i << ", " << j;
    const Vec3 around = unrolled(x + 0.01, y) - unrolled(x - 0.01, y);
    EXPECT_GT(maps.vector("tangent", i, j).dot(around.normalized()), 0.98);
    EXPECT_EQ(maps.at("handedness", i, j), 1);
  });
}

TEST(GeometryMapsBorder, TheBorderOfAChartNeverHidesAnotherChart) {
  const std::vector<Chart> charts = {{{0, 0}, {8, 10}, {1, 0}}, {{1.3, 0}, {23, 10}, {1, 0}}};
  TriangleMesh mesh;
  addSheet(mesh, {0, 0}, {1.3, 1}, charts[0]);
  addSheet(mesh, {1.3, 0}, {2.6, 1}, charts[1]);
  const MapReader without = mapsOf(mesh, kSide, 0), with = mapsOf(mesh, kSide, 6);
  without.forEachTexel([&](int i, int j) {
    if (without.coverage(i, j) == 0) return;
    EXPECT_EQ(with.coverage(i, j), without.coverage(i, j));
    EXPECT_EQ(with.at("chart", i, j), without.at("chart", i, j));
  });
  // Two columns between them: one is the border of each.
  for (int j = 10; j < 20; ++j) {
    EXPECT_EQ(with.at("chart", 21, j), 0);
    EXPECT_EQ(with.at("chart", 22, j), 1);
  }
}

}  // namespace
