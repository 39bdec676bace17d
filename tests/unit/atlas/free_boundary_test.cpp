#include "tools/atlas/flatten/free_boundary.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "bodies.h"
#include "flat_shapes.h"
#include "tools/atlas/charts/stretch.h"
#include "tools/atlas/flatten/flattening.h"
#include "tools/atlas/flatten/injectivity.h"

namespace bakelight::atlas {
namespace {

using tests::wholeChart;

// Σ area · (σ₁² + σ₂² + 1/σ₁² + 1/σ₂²) straight from the singular values.
double symmetricDirichlet(const Chart& chart, const std::vector<Vec2>& plane) {
  double sum = 0;
  for (const Triangle& t : chart.triangles) {
    const std::array<Vec3, 3> corners = {chart.positions[t[0]], chart.positions[t[1]], chart.positions[t[2]]};
    const Singular s = singularValues(corners, {plane[t[0]], plane[t[1]], plane[t[2]]});
    const double area = (corners[1] - corners[0]).cross(corners[2] - corners[0]).norm() / 2;
    sum += area * (s.larger * s.larger + s.smaller * s.smaller + 1 / (s.larger * s.larger) +
                   1 / (s.smaller * s.smaller));
  }
  return sum;
}

std::vector<Vec2> flattened(const Chart& chart) {
  auto start = flatStart(chart);
  EXPECT_TRUE(start.has_value());
  return minimizeDistortion(chart, std::move(*start), {100, 1e-12});
}

// A strip of a surface that is not closed around: quads (i, j), 0 ≤ i ≤ m.
template <class Place>
formats::TriangleMesh patch(std::uint32_t m, std::uint32_t n, const Place& place) {
  formats::TriangleMesh mesh;
  for (std::uint32_t j = 0; j <= n; ++j)
    for (std::uint32_t i = 0; i <= m; ++i)
      mesh.positions.push_back(
          transport::float3(place(static_cast<double>(i) / m, static_cast<double>(j) / n)));
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < m; ++i) {
      const std::uint32_t a = j * (m + 1) + i;
      mesh.triangles.push_back({a, a + 1, a + m + 2});
      mesh.triangles.push_back({a, a + m + 2, a + m + 1});
    }
  return mesh;
}

void expectIsometric(const formats::TriangleMesh& mesh) {
  const Chart chart = wholeChart(mesh);
  const std::vector<Vec2> plane = flattened(chart);
  EXPECT_EQ(badTriangles(chart, plane).count(), 0);
  // Rounding of the positions to float bends a developable surface by about 1e-7.
  EXPECT_NEAR(stretchOf(chart, plane).l2(), 1, 1e-9);
  for (const Triangle& t : chart.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const double length = (chart.positions[t[k]] - chart.positions[t[(k + 1) % 3]]).norm();
      EXPECT_NEAR((plane[t[k]] - plane[t[(k + 1) % 3]]).norm(), length, 2e-5 * length);
    }
}

TEST(FreeBoundary, RollsOutACylinder) {
  expectIsometric(
      patch(40, 10, [](double u, double v) { return Vec3(std::cos(5 * u), std::sin(5 * u), v); }));
}

TEST(FreeBoundary, RollsOutACone) {
  expectIsometric(patch(40, 10, [](double u, double v) {
    const double r = 0.2 + v;
    return Vec3(r * std::cos(4 * u), r * std::sin(4 * u), 2 * r);
  }));
}

TEST(FreeBoundary, LeavesAFlatRingAsItIs) {
  const Chart ring = wholeChart(tests::wrappedGrid(60, 4, false, [](std::uint32_t i, std::uint32_t j) {
    const double u = 2 * std::numbers::pi * i / 60, r = 2 - 0.2 * j;
    return Vec3(r * std::cos(u), r * std::sin(u), 0);
  }));
  ASSERT_EQ(ring.borders.size(), 2u);
  EXPECT_NEAR(stretchOf(ring, flattened(ring)).l2(), 1, 1e-12);
}

TEST(FreeBoundary, BeatsTheMapsOfASphericalCapInTheBooks) {
  constexpr double kHalfAngle = 60;
  const Chart chart = wholeChart(tests::dome(12, kHalfAngle));
  const std::vector<Vec2> plane = flattened(chart);
  EXPECT_TRUE(isInjective(chart, plane));
  // Radii by polar angle of the azimuthal equidistant, equal-area and conformal projections; the chart's unit
  // is that of a whole area of 1.
  const double unit = 1 / std::sqrt(tests::surfaceArea(tests::dome(12, kHalfAngle)));
  const std::array<double (*)(double), 3> radii = {[](double a) { return a; },
                                                   [](double a) { return 2 * std::sin(a / 2); },
                                                   [](double a) { return 2 * std::tan(a / 2); }};
  const formats::TriangleMesh mesh = tests::dome(12, kHalfAngle);
  double best = 1e9;
  for (const auto& radius : radii) {
    std::vector<Vec2> projected;
    for (const std::uint32_t place : chart.places) {
      const Vec3 p = transport::vec3(mesh.positions[place]);
      const double polar = std::acos(std::min(1.0, p.z())), length = std::hypot(p.x(), p.y());
      projected.push_back(
          length > 0 ? Vec2(unit * radius(polar) * p.x() / length, unit * radius(polar) * p.y() / length)
                     : Vec2(0, 0));
    }
    best = std::min(best, symmetricDirichlet(chart, projected));
  }
  EXPECT_LT(symmetricDirichlet(chart, plane), best);
  EXPECT_GT(symmetricDirichlet(chart, plane), 4 * chart.area);  // no sphere is flat
}

TEST(FreeBoundary, IsAMinimum) {
  const Chart chart = wholeChart(tests::dome(6, 70));
  const std::vector<Vec2> plane = flattened(chart);
  // The scaling is for the L² stretch; that of the energy is found along it.
  const double energy = symmetricDirichlet(chart, plane);
  for (std::size_t v = 0; v < plane.size(); ++v)
    for (const Vec2& way : {Vec2(1e-3, 0), Vec2(0, 1e-3), Vec2(-1e-3, 0), Vec2(0, -1e-3)}) {
      std::vector<Vec2> moved = plane;
      moved[v] += way;
      EXPECT_GT(symmetricDirichlet(chart, moved), energy);
    }
}

TEST(FreeBoundary, CopesWithNeedles) {
  formats::TriangleMesh mesh = tests::dome(4, 50);
  // A vertex pulled towards its neighbour until the triangles at that edge are 1e5 times as long as high.
  const auto& t = mesh.triangles[0];
  for (std::size_t k = 0; k < 3; ++k)
    mesh.positions[t[0]][k] =
        mesh.positions[t[1]][k] + 1e-5f * (mesh.positions[t[0]][k] - mesh.positions[t[1]][k]);
  const Chart chart = wholeChart(mesh);
  const std::vector<Vec2> plane = flattened(chart);
  EXPECT_EQ(badTriangles(chart, plane).count(), 0);
  EXPECT_LT(stretchOf(chart, plane).l2(), 1.05);
}

TEST(FreeBoundary, HasNoStartForAClosedBody) {
  EXPECT_FALSE(flatStart(wholeChart(tests::icosphere(1))).has_value());
}

// A flat strip of 20 × 4 squares, with a tooth on each of its upper edge's squares.
formats::TriangleMesh toothedStrip() {
  formats::TriangleMesh mesh = patch(20, 4, [](double u, double v) { return Vec3(20 * u, 4 * v, 0); });
  for (std::uint32_t i = 0; i < 20; ++i) {
    const std::uint32_t left = 4 * 21 + i;
    mesh.positions.push_back({static_cast<float>(i) + 0.5f, 4.8f, 0});
    mesh.triangles.push_back({left, left + 1, static_cast<std::uint32_t>(mesh.positions.size() - 1)});
  }
  return mesh;
}

TEST(StraightenTeeth, DrawsThemFlatAndLeavesCornersAndStraightLines) {
  const Surface surface = surfaceOf(toothedStrip(), "strip.ply");
  std::vector<std::uint32_t> all(surface.triangleCount());
  std::iota(all.begin(), all.end(), 0u);
  FlatteningOptions options;
  options.max_stretch = 1.1;
  options.straightness = 5;
  const FlatPiece before = flatten(surface, all, options).piece.value();
  EXPECT_NEAR(before.stretch.l2(), 1, 1e-9);
  FlatPiece after = before;
  straightenTeeth(after, options);
  EXPECT_TRUE(isInjective(after.chart, after.plane));
  EXPECT_LE(after.stretch.l2(), options.max_stretch);
  const auto borderLength = [](const FlatPiece& piece) {
    double sum = 0;
    const auto& loop = piece.chart.borders[0];
    for (std::size_t i = 0; i < loop.size(); ++i)
      sum += (piece.plane[loop[i]] - piece.plane[loop[(i + 1) % loop.size()]]).norm();
    return sum;
  };
  EXPECT_LT(borderLength(after), 0.95 * borderLength(before));
  // The two lower corners, vertices 0 and 20 of the strip, keep their right angles.
  for (const auto& [corner, beside, above] : {std::array<std::uint32_t, 3>{0, 1, 21}, {20, 19, 41}}) {
    const auto at = [&](std::uint32_t place) {
      const auto it = std::find(after.chart.places.begin(), after.chart.places.end(), place);
      return after.plane[static_cast<std::size_t>(it - after.chart.places.begin())];
    };
    EXPECT_NEAR((at(beside) - at(corner)).normalized().dot((at(above) - at(corner)).normalized()), 0, 0.05);
  }
  // Without room for stretch it stays as it is.
  options.max_stretch = 1 + 1e-7;
  FlatPiece kept = before;
  straightenTeeth(kept, options);
  EXPECT_EQ(kept.plane, before.plane);
}

TEST(StraightenTeeth, LeavesRectanglesAlone) {
  const Surface surface =
      surfaceOf(patch(12, 5, [](double u, double v) { return Vec3(12 * u, 5 * v, 0); }), "rectangle.ply");
  std::vector<std::uint32_t> all(surface.triangleCount());
  std::iota(all.begin(), all.end(), 0u);
  FlatteningOptions options;
  options.max_stretch = 2;
  options.straightness = 50;
  FlatPiece piece = flatten(surface, all, options).piece.value();
  straightenTeeth(piece, options);
  EXPECT_NEAR(piece.stretch.l2(), 1, 1e-9);
}

TEST(Injectivity, FindsTheTurnsOfASpiralOnEachOther) {
  const Chart three_quarters = wholeChart(tests::spiralRibbon(0.75, 60)),
              twice = wholeChart(tests::spiralRibbon(2, 160));
  EXPECT_FALSE(bordersCross(three_quarters, flattened(three_quarters)));
  const std::vector<Vec2> plane = flattened(twice);
  EXPECT_EQ(badTriangles(twice, plane).count(), 0);  // triangle by triangle all is well
  EXPECT_TRUE(bordersCross(twice, plane));
  EXPECT_FALSE(isInjective(twice, plane));
}

TEST(Injectivity, CountsFlippedTrianglesExactly) {
  const Chart chart = wholeChart(tests::flatDisk(1));
  std::vector<Vec2> plane;
  for (const Vec3& p : chart.positions) plane.emplace_back(p.x(), p.y());
  EXPECT_EQ(badTriangles(chart, plane).count(), 0);
  // The middle onto the edge between two of its neighbours, and a hair beyond it.
  const Triangle& t = chart.triangles[0];
  const std::size_t k = chart.places[t[0]] == 0 ? 0 : chart.places[t[1]] == 0 ? 1 : 2;
  const Vec2 a = plane[t[(k + 1) % 3]], b = plane[t[(k + 2) % 3]];
  plane[t[k]] = a;
  EXPECT_EQ(badTriangles(chart, plane).collapsed, 2);  // both triangles at the edge to a have collapsed
  plane[t[k]] = a + 1.5 * (b - a);
  EXPECT_GE(badTriangles(chart, plane).flipped, 1);
}

TEST(Injectivity, FindsHolesTurnedInsideOut) {
  const std::uint32_t sides = 12;
  const Chart ring = wholeChart(tests::wrappedGrid(sides, 1, false, [&](std::uint32_t i, std::uint32_t j) {
    const double u = 2 * std::numbers::pi * i / sides;
    return Vec3((2 - j) * std::cos(u), (2 - j) * std::sin(u), 0);
  }));
  ASSERT_EQ(ring.borders.size(), 2u);
  std::vector<Vec2> plane;
  for (const Vec3& p : ring.positions) plane.emplace_back(p.x(), p.y());
  EXPECT_TRUE(bordersTurnRight(ring, plane));
  EXPECT_TRUE(isInjective(ring, plane));
  // The hole's border mirrored through the axis turns the other way.
  std::vector<Vec2> turned = plane;
  for (const std::uint32_t v : ring.borders[1]) turned[v].y() = -turned[v].y();
  EXPECT_FALSE(bordersTurnRight(ring, turned));
  // And all of it mirrored goes around clockwise.
  for (Vec2& p : plane) p.y() = -p.y();
  EXPECT_FALSE(isInjective(ring, plane));
}

TEST(Stretch, OfKnownMaps) {
  const std::array<Vec3, 3> surface = {Vec3(1, 2, 3), Vec3(3, 2, 3), Vec3(2, 2, 7)};
  const auto planeOf = [](double sx, double sy, double shear) {
    return std::array<Vec2, 3>{Vec2(0, 0), Vec2(2 * sx, 0), Vec2(1 * sx + 4 * shear, 4 * sy)};
  };
  const Singular scaled = singularValues(surface, planeOf(3, 0.5, 0));
  EXPECT_NEAR(scaled.larger, 3, 1e-12);
  EXPECT_NEAR(scaled.smaller, 0.5, 1e-12);
  EXPECT_NEAR(singularValues(surface, planeOf(3, -0.5, 0)).smaller, -0.5, 1e-12);
  // Sander's L² of a map that scales by a and b, at the scale that keeps area: √((a/b + b/a)/2).
  StretchSum sum;
  sum.add(4, scaled, 4 * 1.5);
  EXPECT_NEAR(sum.l2(), std::sqrt((6 + 1.0 / 6) / 2), 1e-12);
  EXPECT_NEAR(sum.lInfinity(), 2 * std::sqrt(1.5), 1e-12);
  EXPECT_NEAR(sum.meanAnisotropy(), 6, 1e-12);
  sum.add(1, singularValues(surface, planeOf(1, 0, 0)), 0);
  EXPECT_TRUE(std::isinf(sum.l2()));
}

}  // namespace
}  // namespace bakelight::atlas
