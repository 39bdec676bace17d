#include "formats/polygon.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace bakelight::formats {
namespace {

double areaOf(const std::vector<Float3>& corners, const Triangle& t) {
  const Float3 &a = corners[t[0]], &b = corners[t[1]], &c = corners[t[2]];
  return (static_cast<double>(b[0] - a[0]) * (c[1] - a[1]) -
          static_cast<double>(b[1] - a[1]) * (c[0] - a[0])) /
         2;
}

// Shoelace.
double areaOf(const std::vector<Float3>& corners) {
  double twice = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Float3 &a = corners[i], &b = corners[(i + 1) % corners.size()];
    twice += static_cast<double>(a[0]) * b[1] - static_cast<double>(a[1]) * b[0];
  }
  return twice / 2;
}

// All triangles turn as the polygon does, so that their areas add up to its own only if none overlap.
void expectDivided(const std::vector<Float3>& corners, const char* what) {
  std::vector<Triangle> triangles;
  EXPECT_TRUE(PolygonTriangulator().triangulate(corners, triangles)) << what;
  ASSERT_EQ(triangles.size(), corners.size() - 2) << what;
  double sum = 0;
  for (const Triangle& t : triangles) {
    const double area = areaOf(corners, t);
    EXPECT_GT(area, 0) << what;
    sum += std::abs(area);
  }
  EXPECT_NEAR(sum, areaOf(corners), 1e-6 * std::abs(areaOf(corners))) << what;
}

std::vector<Float3> star(int corners, float inner) {
  std::vector<Float3> result;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners, radius = i % 2 == 0 ? 1 : inner;
    result.push_back(
        {static_cast<float>(radius * std::cos(angle)), static_cast<float>(radius * std::sin(angle)), 0});
  }
  return result;
}

TEST(Polygon, ConcaveOnesKeepTheirArea) {
  expectDivided({{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}}, "L");
  expectDivided({{0, 0, 0}, {1, 0.2F, 0}, {2, 0, 0}, {1, 3, 0}}, "arrow, reflex at 1");
  expectDivided({{1, 3, 0}, {0, 0, 0}, {1, 0.2F, 0}, {2, 0, 0}}, "arrow, reflex at 2");
  expectDivided(star(10, 0.3F), "star");
  expectDivided(star(5000, 0.5F), "star of 5,000 corners");
  expectDivided(star(5000, 1), "round polygon of 5,000 corners");
  std::vector<Float3> comb = {{0, 0, 0}, {200, 0, 0}};
  for (int i = 100; i-- > 0;) {
    comb.push_back({static_cast<float>(2 * i + 2), 10, 0});
    comb.push_back({static_cast<float>(2 * i + 1), 1, 0});
  }
  comb.push_back({0, 10, 0});
  expectDivided(comb, "comb");
}

TEST(Polygon, CornersWithinEdgesBelongToTrianglesOfArea) {
  expectDivided({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 2, 0}}, "four corners, one of them straight");
  expectDivided({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}},
                "square of eight");
}

TEST(Polygon, BridgesToHolesAreFollowed) {
  // A square of 4 with a square hole of 2, joined at a corner.
  expectDivided({{0, 0, 0},
                 {4, 0, 0},
                 {4, 4, 0},
                 {0, 4, 0},
                 {0, 0, 0},
                 {1, 1, 0},
                 {1, 3, 0},
                 {3, 3, 0},
                 {3, 1, 0},
                 {1, 1, 0}},
                "bridge");
}

TEST(Polygon, AnyPlaneAndSense) {
  const std::vector<Float3> flat = {{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};
  std::vector<Triangle> expected, found;
  PolygonTriangulator triangulator;
  triangulator.triangulate(flat, expected);
  for (const auto& axes : {std::array<std::size_t, 3>{1, 2, 0}, {2, 0, 1}}) {
    std::vector<Float3> turned;
    for (const Float3& p : flat) turned.push_back({p[axes[0]], p[axes[1]], p[axes[2]]});
    found.clear();
    EXPECT_TRUE(triangulator.triangulate(turned, found));
    EXPECT_EQ(found, expected);
  }
  const std::vector<Float3> clockwise(flat.rbegin(), flat.rend());
  found.clear();
  EXPECT_TRUE(triangulator.triangulate(clockwise, found));
  for (const Triangle& t : found) EXPECT_LT(areaOf(clockwise, t), 0);
}

TEST(Polygon, RoundOnesBecomeNoFan) {
  const std::vector<Float3> disk = star(64, 1);
  std::vector<Triangle> triangles;
  PolygonTriangulator().triangulate(disk, triangles);
  std::vector<int> degree(disk.size());
  for (const Triangle& t : triangles)
    for (const std::uint32_t corner : t) ++degree[corner];
  for (const int d : degree) EXPECT_LE(d, 14);
}

TEST(Polygon, WithoutAreaIsTold) {
  for (const std::vector<Float3>& corners :
       std::vector<std::vector<Float3>>{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}},
                                        {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}},
                                        {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}}) {
    std::vector<Triangle> triangles;
    EXPECT_FALSE(PolygonTriangulator().triangulate(corners, triangles));
    EXPECT_EQ(triangles.size(), corners.size() - 2);
  }
}

}  // namespace
}  // namespace bakelight::formats
