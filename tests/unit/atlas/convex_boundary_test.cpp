#include "tools/atlas/flatten/convex_boundary.h"

#include <gtest/gtest.h>

#include "tests/unit/atlas/flat_shapes.h"
#include "tools/atlas/charts/stretch.h"
#include "tools/atlas/exact.h"
#include "tools/atlas/flatten/convex_border.h"

namespace bakelight::atlas {
namespace {

using tests::dome;
using tests::fan;
using tests::flatDisk;
using tests::TriangleMesh;
using tests::wholeChart;

// Path lengths along the outer border from each corner to the next, by walking it.
std::vector<double> pathLengths(const Chart& chart, const std::vector<std::uint32_t>& corners) {
  const auto& loop = chart.borders.front();
  const auto start = static_cast<std::size_t>(std::find(loop.begin(), loop.end(), corners[0]) - loop.begin());
  std::vector<double> lengths;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const std::uint32_t a = loop[(start + i) % loop.size()], b = loop[(start + i + 1) % loop.size()];
    if (lengths.size() < corners.size() && a == corners[lengths.size()]) lengths.push_back(0);
    lengths.back() += (chart.positions[b] - chart.positions[a]).norm();
  }
  return lengths;
}

Vec2 circumcenter(const Vec2& a, const Vec2& b, const Vec2& c) {
  Eigen::Matrix2d rows;
  rows << (b - a).transpose(), (c - a).transpose();
  return a + rows.inverse() * Vec2((b - a).squaredNorm() / 2, (c - a).squaredNorm() / 2);
}

void expectPolygon(const Chart& chart, const ConvexChart& flat) {
  ASSERT_GE(flat.corners.size(), 3u);
  const std::vector<double> lengths = pathLengths(chart, flat.corners);
  ASSERT_EQ(lengths.size(), flat.corners.size());
  const auto corner = [&](std::size_t k) { return flat.plane[flat.corners[k % flat.corners.size()]]; };
  const Vec2 center = circumcenter(corner(0), corner(1), corner(2));
  const double radius = (corner(0) - center).norm(), scale = (corner(1) - corner(0)).norm() / lengths[0];
  for (std::size_t k = 0; k < lengths.size(); ++k) {
    EXPECT_NEAR((corner(k) - center).norm() / radius, 1, 1e-6) << "corner " << k;
    EXPECT_NEAR((corner(k + 1) - corner(k)).norm() / (scale * lengths[k]), 1, 1e-6) << "side " << k;
  }
}

// Whatever the chart: nothing flipped, the chart's area, and a hull that is the border but for the vertices
// that are meant to lie inside.
void expectValid(const Chart& chart, const ConvexChart& flat) {
  ASSERT_EQ(flat.plane.size(), chart.vertexCount());
  double area = 0;
  for (const auto& [a, b, c] : chart.triangles) {
    EXPECT_EQ(orientation(flat.plane[a], flat.plane[b], flat.plane[c]), 1);
    area += crossOf(flat.plane[a], flat.plane[b], flat.plane[c]) / 2;
  }
  EXPECT_NEAR(area / chart.area, 1, 1e-9);
  // Without the vertices that turn right; what is left turns once around, and nowhere right beyond rounding.
  std::vector<Vec2> hull;
  for (const std::uint32_t v : chart.borders.front()) hull.push_back(flat.plane[v]);
  const auto turnAt = [&](std::size_t i) {
    const Vec2 u = hull[i] - hull[(i + hull.size() - 1) % hull.size()],
               v = hull[(i + 1) % hull.size()] - hull[i];
    return std::atan2(u.x() * v.y() - u.y() * v.x(), u.dot(v));
  };
  std::int64_t inside = 0;
  for (std::size_t i = 0; i < hull.size();) {
    if (turnAt(i) > -1e-7) {
      ++i;
      continue;
    }
    hull.erase(hull.begin() + static_cast<std::ptrdiff_t>(i));
    ++inside;
    i = i > 1 ? i - 2 : 0;
  }
  EXPECT_LE(inside, flat.vertices_inside);
  double turned = 0;
  for (std::size_t i = 0; i < hull.size(); ++i) turned += turnAt(i);
  EXPECT_NEAR(turned, 2 * std::numbers::pi, 1e-6);
  EXPECT_LE(flat.l2, flat.mean_value_l2);
  EXPECT_NEAR(stretchOf(chart, flat.plane).l2(), flat.l2, 1e-9 * flat.l2);
}

ConvexChart flattened(const Chart& chart, const ConvexOptions& options = {},
                      const std::vector<std::uint32_t>& corners = {}) {
  return convexBoundary(chart, corners, options).value();
}

// A flat chart with holes whose borders run along the edges of single triangles.
Chart jaggedRing() {
  const TriangleMesh mesh = flatDisk(20);
  const Surface surface = surfaceOf(mesh, "made.ply");
  std::vector<std::int32_t> labels;
  for (std::size_t t = 0; t < surface.triangleCount(); ++t) {
    const Vec3 middle = (surface.corner(t, 0) + surface.corner(t, 1) + surface.corner(t, 2)) / 3;
    const double radius = middle.norm() / surface.scale,
                 noise = 0.1 * std::sin(1234.5 * static_cast<double>(t));
    labels.push_back(radius > 0.3 + noise && radius < 0.8 + noise);
  }
  std::vector<std::uint32_t> largest;
  for (auto& part : connectedParts(surface, labels))
    if (labels[part[0]] == 1 && part.size() > largest.size()) largest = part;
  return chartOf(surface, largest);
}

TEST(Circumradius, OfRegularPolygonsAndTriangles) {
  for (const int sides : {3, 4, 7, 1000})
    EXPECT_NEAR(circumradius(std::vector<double>(sides, 2.5)) * 2 * std::sin(std::numbers::pi / sides) / 2.5,
                1, 1e-12);
  const auto expectTriangle = [](double a, double b, double c) {
    const double s = (a + b + c) / 2, area = std::sqrt(s * (s - a) * (s - b) * (s - c));
    const std::vector<double> lengths = {a, b, c};
    EXPECT_NEAR(circumradius(lengths) / (a * b * c / (4 * area)), 1, 1e-12) << a << " " << b << " " << c;
  };
  expectTriangle(3, 4, 5);
  expectTriangle(3, 3, 2);    // centre inside
  expectTriangle(3, 2, 4.9);  // centre outside
  expectTriangle(4.9, 3, 2);
}

TEST(ConvexBoundary, CornersLieOnACircleAndSidesAreAsLongAsPaths) {
  const Chart hemisphere = wholeChart(dome(12, 90));
  for (const int corners : {3, 5, 8, 40}) {
    const ConvexChart flat = flattened(hemisphere, {.corners = corners});
    EXPECT_EQ(flat.corners.size(), static_cast<std::size_t>(corners));
    EXPECT_EQ(flat.added_corners + flat.bulged_sides + flat.shortened_sides, 0);
    expectPolygon(hemisphere, flat);
    expectValid(hemisphere, flat);
  }
  const ConvexChart octagon = flattened(hemisphere);
  const std::vector<double> lengths = pathLengths(hemisphere, octagon.corners);
  const auto [least, most] = std::minmax_element(lengths.begin(), lengths.end());
  EXPECT_LE(*most - *least, 1.01 * *least / 9);  // 9 edges a side: snapped to the nearest vertex
}

TEST(ConvexBoundary, ChosenCornersAreTheCorners) {
  const Chart chart = wholeChart(dome(8, 70));
  const auto& loop = chart.borders.front();
  std::uint32_t inner = 0;
  while (std::find(loop.begin(), loop.end(), inner) != loop.end()) ++inner;
  const ConvexChart flat = flattened(chart, {}, {loop[30], loop[2], loop[17], loop[9], inner});
  EXPECT_EQ(flat.corners, (std::vector<std::uint32_t>{loop[2], loop[9], loop[17], loop[30]}));
  EXPECT_EQ(flat.added_corners, 0);
  expectPolygon(chart, flat);
  expectValid(chart, flat);
}

TEST(ConvexBoundary, APathLongerThanTheOthersIsDivided) {
  const Chart chart = wholeChart(dome(8, 70));
  const auto& loop = chart.borders.front();
  const ConvexChart three = flattened(chart, {}, {loop[0], loop[2], loop[4]});
  EXPECT_GT(three.added_corners, 0);
  expectPolygon(chart, three);
  expectValid(chart, three);
  const ConvexChart one = flattened(chart, {}, {loop[5]});
  EXPECT_EQ(one.corners.size(), 3u + (one.added_corners - 2));
  EXPECT_NE(std::find(one.corners.begin(), one.corners.end(), loop[5]), one.corners.end());
  expectPolygon(chart, one);
  expectValid(chart, one);
}

TEST(ConvexBoundary, AFlatDiskInACircleIsAlmostAnIsometry) {
  const Chart chart = wholeChart(flatDisk(20));
  const ConvexChart flat = flattened(chart, {.corners = 120});
  EXPECT_EQ(flat.corners.size(), 120u);
  EXPECT_LT(flat.l2, 1.0005);
  expectValid(chart, flat);
}

// The least stretch of a map of the unit sphere's cap of 150° that takes circles to circles: its radius r(θ)
// at a fixed border minimises ∫ sin θ (1/r′² + (sin θ/r)²) dθ, which is convex; solved by Newton's method
// with 2,000 nodes, L² = 1.15225. The mesh's triangles make the sphere a little less than round.
TEST(ConvexBoundary, ADomeComesToTheLeastStretchOfRadialMaps) {
  const Chart chart = wholeChart(dome(57, 150));
  ASSERT_GT(chart.vertexCount(), 9900u);
  const ConvexChart flat = flattened(chart, {.corners = 342});
  EXPECT_GT(flat.mean_value_l2, 1.5);
  EXPECT_NEAR(flat.l2, 1.15225, 0.002);
  expectValid(chart, flat);
  const ConvexChart octagon = flattened(chart);
  EXPECT_NEAR(octagon.l2, 1.15225, 0.01);
  expectValid(chart, octagon);
}

TEST(ConvexBoundary, JaggedBordersKeepTheirTeethAndHolesStayOpen) {
  const Chart chart = jaggedRing();
  ASSERT_GE(chart.borders.size(), 2u);
  ASSERT_GT(chart.triangles.size(), 1000u);
  const ConvexChart flat = flattened(chart);
  EXPECT_EQ(flat.bulged_sides, 0);
  EXPECT_GT(flat.vertices_inside, 10);
  EXPECT_LT(flat.l2, 1.5);  // 10 and more if teeth lay flat on their sides
  expectPolygon(chart, flat);
  expectValid(chart, flat);
  const auto areaOf = [&](const std::vector<std::uint32_t>& loop) {
    double twice = 0;
    for (std::size_t i = 0; i < loop.size(); ++i)
      twice += crossOf(Vec2::Zero(), flat.plane[loop[i]], flat.plane[loop[(i + 1) % loop.size()]]);
    return twice / 2;
  };
  EXPECT_LT(areaOf(chart.borders[1]), -0.05 * chart.area);
  double sum = 0;  // holes run the other way round
  for (const auto& loop : chart.borders) sum += areaOf(loop);
  EXPECT_NEAR(sum, chart.area, 1e-9);
}

TEST(ConvexBoundary, ASlitIsClosed) {
  Surface surface = surfaceOf(flatDisk(3), "made.ply");
  ASSERT_EQ(cutEdges(surface, std::vector<std::array<std::uint32_t, 2>>{{0, 1}}), 1);
  std::vector<std::uint32_t> all(surface.triangleCount());
  std::iota(all.begin(), all.end(), 0u);
  const Chart chart = chartOf(surface, all);
  ASSERT_EQ(chart.borders.size(), 2u);
  ASSERT_EQ(chart.borders[1].size(), 2u);
  expectValid(chart, flattened(chart));
}

TEST(ConvexBoundary, AFanOfAThousandTriangles) {
  for (const double height : {0.0, 1.0, 100.0}) {
    const Chart chart = wholeChart(fan(1000, height));
    const ConvexChart flat = flattened(chart);
    expectPolygon(chart, flat);
    expectValid(chart, flat);
  }
  // Half of it: its apex lies on the border, and all other edges start there.
  TriangleMesh half = fan(1000, 0.5);
  half.triangles.resize(500);
  const Chart chart = wholeChart(half);
  const auto& loop = chart.borders.front();
  const ConvexChart flat = flattened(chart, {}, {loop[100], loop[250], loop[400]});
  EXPECT_GT(flat.bulged_sides, 0);
  expectPolygon(chart, flat);
  expectValid(chart, flat);
}

TEST(ConvexBoundary, OneTriangleKeepsItsShape) {
  for (const double height : {0.8, 1e-6}) {
    TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {0, 1, 0}, {0.3f, 0.5f, static_cast<float>(height)}};
    mesh.triangles = {{0, 1, 2}};
    const Chart chart = wholeChart(mesh);
    const ConvexChart flat = flattened(chart);
    expectPolygon(chart, flat);
    expectValid(chart, flat);
    EXPECT_NEAR(stretchOf(chart, flat.plane).l2(), 1, 1e-6);
  }
}

TEST(ConvexBoundary, NeedlesDoNotFlip) {
  const TriangleMesh mesh = tests::rings(10, [](double r, double angle) {
    return Vec3(1e6 * r * std::cos(angle), r * std::sin(angle), 0.1 * r * r);
  });
  const Chart chart = wholeChart(mesh);
  const ConvexChart flat = flattened(chart);
  expectValid(chart, flat);
  TriangleMesh strip;  // two triangles, a needle each
  strip.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1e-6f, 0}, {0, 1e-6f, 0}};
  strip.triangles = {{0, 1, 2}, {0, 2, 3}};
  const Chart quad = wholeChart(strip);
  const ConvexChart flat_quad = flattened(quad);
  expectPolygon(quad, flat_quad);
  expectValid(quad, flat_quad);
}

// Each joint shrinks what lies behind it a few times: a hundred leave nothing that doubles could tell apart.
TEST(ConvexBoundary, AFingerTooLongForDoublesIsNotLaid) {
  const auto finger = [](std::uint32_t joints) {
    TriangleMesh mesh = tests::rings(
        1, [](double r, double angle) { return Vec3(r * std::cos(angle), r * std::sin(angle), 0); });
    for (std::uint32_t j = 0; j < joints; ++j)
      for (std::uint32_t k = 0; k < 6; ++k) {
        const std::uint32_t a = 1 + 6 * j + k, b = 1 + 6 * j + (k + 1) % 6;
        const auto& above = mesh.positions[a];
        mesh.positions.push_back({above[0], above[1], above[2] - 1});
        mesh.triangles.push_back({a, a + 6, b});
        mesh.triangles.push_back({b, a + 6, b + 6});
      }
    return wholeChart(mesh);
  };
  const Chart knuckle = finger(8);
  expectValid(knuckle, flattened(knuckle));
  EXPECT_FALSE(convexBoundary(finger(100), {}, {}).has_value());
}

TEST(ConvexBoundary, OnlyDisksAreTaken) {
  EXPECT_FALSE(canBeConvex(wholeChart(tests::icosphere(1))));
  EXPECT_THROW(convexBoundary(wholeChart(tests::icosphere(1)), {}, {}), std::logic_error);
  EXPECT_TRUE(canBeConvex(wholeChart(flatDisk(1))));
}

}  // namespace
}  // namespace bakelight::atlas
