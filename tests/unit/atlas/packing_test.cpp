#include "tools/atlas/packing/packing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>
#include <limits>

#include "formats/error.h"
#include "tests/unit/atlas/flat_charts.h"
#include "tools/atlas/packing/layout_search.h"

namespace bakelight::atlas {
namespace {

using namespace tests;
using Corners = std::array<Vec2, 3>;

double distanceToSegment(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 along = b - a;
  const double length = along.squaredNorm();
  const double t = length > 0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0;
  return (a + t * along - p).norm();
}

// Separating axes of an open square of side 1 at (x, y) and a triangle.
bool overlap(const Corners& triangle, double x, double y) {
  const std::array<Vec2, 4> square = {Vec2(x, y), Vec2(x + 1, y), Vec2(x + 1, y + 1), Vec2(x, y + 1)};
  std::vector<Vec2> axes = {Vec2(1, 0), Vec2(0, 1)};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec2 edge = triangle[(k + 1) % 3] - triangle[k];
    if (edge.squaredNorm() > 0) axes.emplace_back(-edge.y(), edge.x());
  }
  for (const Vec2& axis : axes) {
    double low_t = 1e300, high_t = -1e300, low_s = 1e300, high_s = -1e300;
    for (const Vec2& p : triangle)
      low_t = std::min(low_t, axis.dot(p)), high_t = std::max(high_t, axis.dot(p));
    for (const Vec2& p : square) low_s = std::min(low_s, axis.dot(p)), high_s = std::max(high_s, axis.dot(p));
    if (high_t <= low_s || high_s <= low_t) return false;
  }
  return true;
}

// Whether the texel (x, y) overlaps the triangle blown up by `radius`.
bool touches(const Corners& triangle, int x, int y, double radius) {
  if (overlap(triangle, x, y)) return true;
  if (radius == 0) return false;
  double distance = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k)
    for (int i = 0; i < 4; ++i) {
      const Vec2 a(x + (i == 1 || i == 2), y + (i >= 2)), b(x + (i == 0 || i == 1), y + (i == 1 || i == 2));
      const Vec2 &c = triangle[k], &d = triangle[(k + 1) % 3];
      distance = std::min({distance, distanceToSegment(a, c, d), distanceToSegment(c, a, b)});
    }
  return distance < radius;
}

struct Figures {
  std::int64_t touched_texels = 0;
  double utilisation = 0;                          // share of texels whose centre is in a triangle
  int smallest_distance = 1 << 20;                 // largest of |Δi| and |Δj| of texels of different charts
  int least_index = 1 << 20, greatest_index = -1;  // of touched texels, rows and columns
  bool each_touches = true;
};

// Brute force. With `as_floats` the coordinates are those that are written to a mesh, and nothing is blown
// up.
Figures figuresOf(const std::vector<FlatChart>& charts, const Packing& packing, int resolution,
                  bool as_floats, int greatest_distance) {
  Figures figures;
  constexpr int kAround = 3;  // texels outside of the square that are looked at, too
  const int side = resolution + 2 * kAround;
  std::vector<int> owner(static_cast<std::size_t>(side) * side, -1);
  const auto ownerAt = [&](int x, int y) -> int& {
    return owner[static_cast<std::size_t>(y + kAround) * side + x + kAround];
  };
  std::int64_t centers = 0;
  for (std::size_t c = 0; c < charts.size(); ++c) {
    const auto& [angle, offset] = packing.placements[c];
    std::vector<Vec2> placed;
    for (const Vec2& v : charts[c].vertices) {
      const Vec2 turned(std::cos(angle) * v.x() - std::sin(angle) * v.y(),
                        std::sin(angle) * v.x() + std::cos(angle) * v.y());
      Vec2 p = packing.texels_per_unit * turned + offset;
      if (as_floats) p = resolution * (p / resolution).cast<float>().cast<double>();
      placed.push_back(p);
    }
    std::int64_t own_texels = 0;
    for (const formats::Triangle& t : charts[c].triangles) {
      const Corners corners = {placed[t[0]], placed[t[1]], placed[t[2]]};
      const Vec2 low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]);
      const Vec2 high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
      const auto clamped = [&](double v) {
        return std::clamp(static_cast<int>(std::floor(v)), -kAround, resolution + kAround - 1);
      };
      for (int y = clamped(low.y() - 1); y <= clamped(high.y() + 1); ++y)
        for (int x = clamped(low.x() - 1); x <= clamped(high.x() + 1); ++x) {
          if (!touches(corners, x, y, as_floats ? 0 : 1.0 / 64)) continue;
          int& texel = ownerAt(x, y);
          if (texel >= 0 && texel != static_cast<int>(c)) figures.smallest_distance = 0;
          if (texel < 0) ++own_texels;
          texel = static_cast<int>(c);
          figures.least_index = std::min({figures.least_index, x, y});
          figures.greatest_index = std::max({figures.greatest_index, x, y});
          const auto left = [&](std::size_t k) {
            const Vec2 e = corners[(k + 1) % 3] - corners[k], p = Vec2(x + 0.5, y + 0.5) - corners[k];
            return e.x() * p.y() - e.y() * p.x() > 0;
          };
          if (left(0) && left(1) && left(2)) ++centers;
        }
    }
    figures.touched_texels += own_texels;
    figures.each_touches = figures.each_touches && own_texels > 0;
  }
  for (int y = 0; y < resolution; ++y)
    for (int x = 0; x < resolution; ++x) {
      if (ownerAt(x, y) < 0) continue;
      for (int dy = 0; dy <= greatest_distance && y + dy < resolution; ++dy)
        for (int dx = -greatest_distance; dx <= greatest_distance; ++dx) {
          if (x + dx < 0 || x + dx >= resolution) continue;
          const int other = ownerAt(x + dx, y + dy);
          if (other >= 0 && other != ownerAt(x, y))
            figures.smallest_distance = std::min(figures.smallest_distance, std::max(std::abs(dx), dy));
        }
    }
  figures.utilisation = static_cast<double>(centers) / resolution / resolution;
  return figures;
}

// Packs, and asserts what packing.h guarantees. Returns the share of texels used.
double utilisationOf(const std::vector<FlatChart>& charts, const PackingOptions& options) {
  const Packing packing = pack(charts, options, "made.ply");
  EXPECT_EQ(packing.placements.size(), charts.size());
  EXPECT_GT(packing.texels_per_unit, 0);
  const int distance = options.gutter + 2 * options.border;
  double utilisation = 0;
  for (const bool as_floats : {false, true}) {
    const Figures figures = figuresOf(charts, packing, options.resolution, as_floats, distance + 1);
    EXPECT_TRUE(figures.each_touches);
    EXPECT_GE(figures.touched_texels, static_cast<std::int64_t>(charts.size()));
    EXPECT_GT(figures.smallest_distance, distance) << "resolution " << options.resolution;
    EXPECT_GE(figures.least_index, options.border);
    EXPECT_LT(figures.greatest_index, options.resolution - options.border);
    utilisation = figures.utilisation;
  }
  return utilisation;
}

PackingOptions optionsOf(int resolution, int gutter, int border = 0) {
  return {resolution, gutter, border};
}

TEST(Packing, JaggedChartsKeepTheirDistance) {
  const auto charts = starCharts(6, 0.8, 1);
  for (const auto& [gutter, border] : {std::pair{0, 0}, {1, 0}, {2, 3}, {5, 0}})
    utilisationOf(charts, optionsOf(150, gutter, border));
}

// More than are searched for: each is placed once, from below.
TEST(Packing, ManyChartsKeepTheirDistance) {
  const auto charts = starCharts(static_cast<int>(kMostChartsSearched) + 1, 1.5, 3);
  for (const auto& [gutter, border] : {std::pair{0, 0}, {1, 0}, {2, 1}, {4, 0}})
    EXPECT_GT(utilisationOf(charts, optionsOf(256, gutter, border)), 0.1);
}

TEST(Packing, FillsMostOfTheSquareWithJaggedCharts) {
  // xatlas 0.7 fills two thirds with charts like these; seeds differ by about 0.01.
  EXPECT_GE(utilisationOf(starCharts(30, 0.7, 2), optionsOf(512, 2)), 0.75);
}

TEST(Packing, SquaresFillTheSquare) {
  // A square of 64 texels with one free texel on each side by the blow-up, in four turns.
  EXPECT_GT(utilisationOf({rectangleChart(3, 3)}, optionsOf(64, 2)), 0.93);
  // Four squares and a gutter of two: (31 − 1)² each.
  EXPECT_GT(utilisationOf(std::vector<FlatChart>(4, rectangleChart(1, 1)), optionsOf(64, 2)), 0.8);
}

TEST(Packing, HolesAreUsed) {
  // Without its hole the ring alone leaves no room for a disk of more than a tenth of its radius.
  const std::vector<FlatChart> charts = {ringChart(60, 0.8, 1), ringChart(40, 0.1, 0.7)};
  const Packing packing = pack(charts, optionsOf(128, 2), "made.ply");
  EXPECT_GT(packing.texels_per_unit * 2, 110);
  utilisationOf(charts, optionsOf(128, 2));
}

TEST(Packing, LShapesInterlock) {
  // Boxes of 2 × 2 would fill three quarters of the square at most, and lose gutters then.
  EXPECT_GT(utilisationOf(std::vector<FlatChart>(8, lChart(1)), optionsOf(256, 1)), 0.75);
}

TEST(Packing, ChartsKeepTheirSizesRelativeToEachOther) {
  std::vector<FlatChart> charts = {rectangleChart(1, 1), rectangleChart(1e-5, 1e-5),
                                   rectangleChart(1e-3, 2e-3), starChart(9, 3e-5, 0.1, 4)};
  utilisationOf(charts, optionsOf(64, 1));
}

TEST(Packing, SliversLieAcross) {
  // Longer than the side: on the diagonal.
  const Packing packing = pack({{rectangleChart(1, 1e-6)}}, optionsOf(128, 2), "made.ply");
  EXPECT_GT(packing.texels_per_unit, 160);
  EXPECT_GT(pack({{rectangleChart(1, 1e-12)}}, optionsOf(128, 2), "made.ply").texels_per_unit, 160);
  utilisationOf({rectangleChart(1, 1e-6), rectangleChart(1, 1e-6), rectangleChart(0.5, 0.4)},
                optionsOf(128, 2));
}

TEST(Packing, LengthsHaveAnyUnit) {
  for (const double unit : {1e-9, 1e9}) {
    auto charts = starCharts(3, 0.5, 5);
    for (FlatChart& chart : charts)
      for (Vec2& v : chart.vertices) v *= unit;
    EXPECT_GT(utilisationOf(charts, optionsOf(64, 1)), 0.4);
  }
}

TEST(Packing, FewTexels) {
  for (const int count : {1, 3, 36}) utilisationOf(starCharts(count, 0.3, 6), optionsOf(16, 2));
}

TEST(Packing, ManyTexels) {
  // 2 × 2 of the square's texels are one of the grid's in which the charts are placed.
  std::vector<FlatChart> charts = {ringChart(90, 0.9, 1)};
  for (int i = 0; i < 16; ++i) charts.push_back(rectangleChart(0.2 + 0.01 * i, 0.3 - 0.013 * i));
  for (const auto& [gutter, border] : {std::pair{3, 0}, {2, 1}})
    EXPECT_GT(utilisationOf(charts, optionsOf(1100, gutter, border)), 0.1);
}

TEST(Packing, AsManyTexelsAsHaveRoom) {
  // (64 + 2) ÷ 3 = 22 in a row.
  const std::vector<FlatChart> charts(22 * 22, rectangleChart(1, 1));
  utilisationOf(charts, optionsOf(64, 2));
}

TEST(Packing, OneMoreThanHasRoomIsAnError) {
  const std::vector<FlatChart> charts(22 * 22 + 1, rectangleChart(1, 1));
  try {
    pack(charts, optionsOf(64, 2), "many.ply");
    FAIL() << "packed";
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    EXPECT_EQ(error.place().file, "many.ply");
    EXPECT_THAT(error.problem(), testing::HasSubstr("485 charts do not fit"));
    EXPECT_THAT(error.problem(), testing::HasSubstr("each takes 9"));
    EXPECT_THAT(error.expected(), testing::HasSubstr("67"));  // 23 · 3 − 2
  }
  EXPECT_EQ(pack(charts, optionsOf(67, 2), "many.ply").placements.size(), charts.size());
}

TEST(Packing, NoCharts) {
  EXPECT_TRUE(pack({}, {}, "made.ply").placements.empty());
}

TEST(Packing, AHundredThousandCharts) {
  const std::vector<FlatChart> charts(100'000, rectangleChart(1, 1.5));
  const Packing packing = pack(charts, optionsOf(1024, 2), "made.ply");
  const Figures figures = figuresOf(charts, packing, 1024, true, 3);
  EXPECT_GE(figures.touched_texels, 100'000);
  EXPECT_GT(figures.smallest_distance, 2);
  EXPECT_GE(figures.least_index, 0);
  EXPECT_LT(figures.greatest_index, 1024);
}

TEST(Packing, SameForAnyNumberOfThreads) {
  const auto charts = starCharts(5, 0.6, 8);
  const auto packed = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return pack(charts, optionsOf(100, 2), "made.ply");
  };
  const Packing one = packed(1), three = packed(3);
  EXPECT_EQ(one.texels_per_unit, three.texels_per_unit);
  ASSERT_EQ(one.placements.size(), charts.size());
  for (std::size_t i = 0; i < charts.size(); ++i) {
    EXPECT_EQ(one.placements[i].angle_rad, three.placements[i].angle_rad);
    EXPECT_EQ(one.placements[i].offset, three.placements[i].offset);
  }
}

}  // namespace
}  // namespace bakelight::atlas
