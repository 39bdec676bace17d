#include "tools/atlas/maps/raster.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <set>
#include <utility>

using namespace bakelight::atlas;

namespace {

constexpr int kSide = 16;
// Corners lie on a lattice of quarter texels: many on centres, and edges through them; integers are exact.
constexpr std::int64_t kUnit = 4;

struct Point {
  std::int64_t x, y;
};
using IntegerTriangle = std::array<Point, 3>;

std::int64_t cross(const Point& a, const Point& b, const Point& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

TexelTriangle inTexels(const IntegerTriangle& t) {
  TexelTriangle result;
  for (std::size_t k = 0; k < 3; ++k)
    result[k] = Vec2(static_cast<double>(t[k].x), static_cast<double>(t[k].y)) / kUnit;
  return result;
}

// The top-left rule as what it comes from: the centre is moved right by ε and down by ε².
bool hasCenter(IntegerTriangle t, const Point& p) {
  if (cross(t[0], t[1], t[2]) == 0) return false;
  if (cross(t[0], t[1], t[2]) < 0) std::swap(t[1], t[2]);
  for (std::size_t k = 0; k < 3; ++k) {
    const Point &a = t[k], &b = t[(k + 1) % 3];
    const std::int64_t side = cross(a, b, p), moved_right = a.y - b.y, moved_down = a.x - b.x;
    if ((side != 0 ? side : moved_right != 0 ? moved_right : moved_down) < 0) return false;
  }
  return true;
}

// Separating axes of the closed triangle and the open square.
bool meetsTexel(const IntegerTriangle& t, int i, int j) {
  const Point low = {i * kUnit, j * kUnit}, high = {low.x + kUnit, low.y + kUnit};
  const std::array<Point, 4> square = {low, {high.x, low.y}, high, {low.x, high.y}};
  const auto separates = [&](const Point& axis) {
    const auto along = [&](const Point& p) { return p.x * axis.x + p.y * axis.y; };
    const auto [t_low, t_high] = std::minmax({along(t[0]), along(t[1]), along(t[2])});
    const auto [s_low, s_high] =
        std::minmax({along(square[0]), along(square[1]), along(square[2]), along(square[3])});
    return t_high <= s_low || s_high <= t_low;
  };
  if (separates({1, 0}) || separates({0, 1})) return false;
  for (std::size_t k = 0; k < 3; ++k) {
    const Point &a = t[k], &b = t[(k + 1) % 3];
    // Across the edge, and, for what has no area, along it.
    for (const Point& axis : {Point{a.y - b.y, b.x - a.x}, Point{b.x - a.x, b.y - a.y}})
      if ((axis.x != 0 || axis.y != 0) && separates(axis)) return false;
  }
  return true;
}

std::set<std::pair<int, int>> texelsOf(const std::vector<RowSpan>& spans) {
  std::set<std::pair<int, int>> texels;
  for (const RowSpan& span : spans)
    for (int i = span.begin; i < span.end; ++i) EXPECT_TRUE(texels.emplace(i, span.row).second);
  return texels;
}

class RandomLattice {
 public:
  Point point() { return {coordinate(), coordinate()}; }
  IntegerTriangle triangle() { return {point(), point(), point()}; }

 private:
  // A little beyond the square, too.
  std::int64_t coordinate() { return distribution_(engine_); }
  std::mt19937 engine_{5};
  std::uniform_int_distribution<std::int64_t> distribution_{-kUnit, (kSide + 1) * kUnit};
};

TEST(Raster, CentersAreThoseOfExactArithmetic) {
  RandomLattice lattice;
  std::vector<RowSpan> spans;
  std::int64_t on_edges = 0;
  for (int n = 0; n < 3000; ++n) {
    const IntegerTriangle triangle = lattice.triangle();
    centerSpans(inTexels(triangle), kSide, spans);
    const auto texels = texelsOf(spans);
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i) {
        const Point center = {i * kUnit + kUnit / 2, j * kUnit + kUnit / 2};
        ASSERT_EQ(texels.count({i, j}) != 0, hasCenter(triangle, center)) << n << ": " << i << ", " << j;
        for (std::size_t k = 0; k < 3; ++k)
          on_edges += cross(triangle[k], triangle[(k + 1) % 3], center) == 0;
      }
  }
  EXPECT_GT(on_edges, 3000);
}

TEST(Raster, TouchedTexelsAreThoseOfExactArithmetic) {
  RandomLattice lattice;
  std::vector<RowSpan> spans;
  int flat = 0;
  for (int n = 0; n < 3000; ++n) {
    IntegerTriangle triangle = lattice.triangle();
    if (n % 10 == 0) triangle[2] = triangle[n % 20 == 0];
    flat += cross(triangle[0], triangle[1], triangle[2]) == 0;
    touchedSpans(inTexels(triangle), kSide, spans);
    const auto texels = texelsOf(spans);
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i)
        ASSERT_EQ(texels.count({i, j}) != 0, meetsTexel(triangle, i, j)) << n << ": " << i << ", " << j;
  }
  EXPECT_GE(flat, 300);
}

// Where an edge runs through corners of texels, rounding (1/49 · 49 < 1) must not touch what lies beyond.
TEST(Raster, DiagonalsTouchNothingBeyondTheCornersOfTexels) {
  std::vector<RowSpan> spans;
  for (int n = 1; n <= 63; ++n) {
    touchedSpans({Vec2(0, 0), Vec2(n, 0), Vec2(n, n)}, 64, spans);
    ASSERT_EQ(spans.size(), static_cast<std::size_t>(n));
    for (const RowSpan& span : spans) EXPECT_EQ(span.begin, span.row) << n;
    touchedSpans({Vec2(0, 0), Vec2(n, n), Vec2(0, n)}, 64, spans);
    ASSERT_EQ(spans.size(), static_cast<std::size_t>(n));
    for (const RowSpan& span : spans) EXPECT_EQ(span.end, span.row + 1) << n;
  }
}

// A point inside the square with all corners of a loop around it: triangles that share edges and one corner.
TEST(Raster, FansClaimEachCenterOnce) {
  std::mt19937 engine(7);
  std::uniform_int_distribution<int> inside(1, 4 * kSide - 1);
  std::vector<RowSpan> spans;
  for (int n = 0; n < 200; ++n) {
    const Vec2 middle = Vec2(inside(engine), inside(engine)) / 4;
    std::vector<Vec2> loop;
    for (int side = 0; side < 4; ++side)
      for (int i = 0; i < kSide; ++i) {
        const double along = i, far = kSide;
        loop.push_back(side == 0   ? Vec2(along, 0)
                       : side == 1 ? Vec2(far, along)
                       : side == 2 ? Vec2(far - along, far)
                                   : Vec2(0, far - along));
      }
    std::vector<int> claims(kSide * kSide, 0);
    for (std::size_t k = 0; k < loop.size(); ++k) {
      centerSpans({middle, loop[k], loop[(k + 1) % loop.size()]}, kSide, spans);
      for (const auto& [i, j] : texelsOf(spans)) ++claims[j * kSide + i];
    }
    EXPECT_EQ(std::count(claims.begin(), claims.end(), 1), kSide * kSide);
  }
}

// Where double arithmetic alone finds three points on a line: Kettner et al. 2008, "Classroom examples of
// robustness problems in geometric computations".
TEST(Raster, SidesAreExactWhereDoublesAreNot) {
  const Vec2 on_line(0.5, 0.5), right(0.5 + 0x1p-52, 0.5), left(0.5, 0.5 + 0x1p-52), b(12, 12), c(24, 24);
  EXPECT_EQ(orientationOf(on_line, b, c), 0);
  EXPECT_EQ(orientationOf(b, c, right), -1);
  EXPECT_EQ(orientationOf(right, b, c), -1);
  EXPECT_EQ(orientationOf(left, b, c), 1);
}

TEST(Raster, WhatIsNotFiniteCoversNothing) {
  std::vector<RowSpan> spans = {{0, 0, 1}};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  centerSpans({Vec2(0, 0), Vec2(8, nan), Vec2(0, 8)}, kSide, spans);
  EXPECT_TRUE(spans.empty());
  touchedSpans({Vec2(0, 0), Vec2(8, nan), Vec2(0, 8)}, kSide, spans);
  EXPECT_TRUE(spans.empty());
  centerSpans({Vec2(-1e30, -1e30), Vec2(1e30, -1e30), Vec2(0, 1e30)}, kSide, spans);
  EXPECT_EQ(texelsOf(spans).size(), kSide * kSide);
}

}  // namespace
