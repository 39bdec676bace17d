// Flat charts made by code.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "tools/atlas/packing/packing.h"
#include "transport/random.h"

namespace bakelight::tests {

using atlas::FlatChart;
using atlas::Vec2;

// Numbers in [0, 1), the same for the same seed.
class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : state_(transport::scrambled(seed)) {}
  double next() { return static_cast<double>((state_ = transport::scrambled(state_)) >> 11) * 0x1p-53; }

 private:
  std::uint64_t state_;
};

// Seen from a point inside all of the border is visible: a fan of `corners` triangles. Lobed and jagged.
inline FlatChart starChart(int corners, double size, double jaggedness, std::uint64_t seed) {
  Numbers numbers(seed);
  const double lobes = 2 + std::floor(3 * numbers.next()), depth = 0.3 * numbers.next(),
               stretch = 1 + numbers.next();
  FlatChart chart;
  chart.vertices.push_back(Vec2(7, -3));
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    const double radius =
        size * (1 + depth * std::cos(lobes * angle)) * (1 + jaggedness * (numbers.next() - 0.5));
    chart.vertices.push_back(chart.vertices[0] +
                             Vec2(stretch * radius * std::cos(angle), radius * std::sin(angle)));
    chart.triangles.push_back(
        {0, 1 + static_cast<std::uint32_t>(i), 1 + static_cast<std::uint32_t>((i + 1) % corners)});
  }
  return chart;
}

inline FlatChart rectangleChart(double width, double height) {
  return {{Vec2(0, 0), Vec2(width, 0), Vec2(width, height), Vec2(0, height)}, {{0, 1, 2}, {0, 2, 3}}};
}

// Two squares of `size` and one between them, in the shape of an L.
inline FlatChart lChart(double size) {
  const auto at = [&](double x, double y) { return Vec2(size * x, size * y); };
  return {{at(0, 0), at(1, 0), at(2, 0), at(2, 1), at(1, 1), at(1, 2), at(0, 2), at(0, 1)},
          {{0, 1, 4}, {0, 4, 7}, {1, 2, 3}, {1, 3, 4}, {7, 4, 5}, {7, 5, 6}}};
}

// With a hole.
inline FlatChart ringChart(int corners, double inner_radius, double outer_radius) {
  FlatChart chart;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    for (const double radius : {inner_radius, outer_radius})
      chart.vertices.push_back(radius * Vec2(std::cos(angle), std::sin(angle)));
    const auto a = static_cast<std::uint32_t>(2 * i), b = static_cast<std::uint32_t>(2 * ((i + 1) % corners));
    chart.triangles.push_back({a, a + 1, b + 1});
    chart.triangles.push_back({a, b + 1, b});
  }
  return chart;
}

// Stars of sizes that differ by up to exp(2 · spread).
inline std::vector<FlatChart> starCharts(int count, double spread, std::uint64_t seed) {
  Numbers numbers(seed);
  std::vector<FlatChart> charts;
  for (int i = 0; i < count; ++i) {
    const double size = std::exp(spread * (2 * numbers.next() - 1));
    charts.push_back(starChart(std::clamp(static_cast<int>(60 * size), 5, 150), size, 0.15,
                               seed * 1000 + static_cast<std::uint64_t>(i)));
  }
  return charts;
}

}  // namespace bakelight::tests
