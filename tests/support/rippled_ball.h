// A ball with ripples of three sizes, for benchmarks that need meshes of any number of triangles.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "formats/triangle_mesh.h"
#include "transport/vector_types.h"

namespace bakelight::tests {

// radius = 1 + 0.12 sin 3θ sin 4φ + 0.05 sin(9θ + 1) sin 7φ + 0.01 sin(41θ + 3) sin 39φ,
// θ the angle from +Y, φ the one around it.
inline transport::Vec3 onRippledBall(const transport::Vec3& direction) {
  const transport::Vec3 d = direction.normalized();
  const double theta = std::acos(std::clamp(d.y(), -1.0, 1.0)), phi = std::atan2(d.z(), d.x());
  const double radius = 1 + 0.12 * std::sin(3 * theta) * std::sin(4 * phi) +
                        0.05 * std::sin(9 * theta + 1) * std::sin(7 * phi) +
                        0.01 * std::sin(41 * theta + 3) * std::sin(39 * phi);
  return radius * d;
}

// Closed, without normals, counter-clockwise seen from outside: 20 n² triangles, n such that they come next
// to `triangles`. Each face of an icosahedron is divided into n² and lifted to the ball.
inline formats::TriangleMesh rippledBall(std::size_t triangles) {
  constexpr double kGolden = std::numbers::phi;
  const std::array<transport::Vec3, 12> corners = {{{-1, kGolden, 0},
                                                    {1, kGolden, 0},
                                                    {-1, -kGolden, 0},
                                                    {1, -kGolden, 0},
                                                    {0, -1, kGolden},
                                                    {0, 1, kGolden},
                                                    {0, -1, -kGolden},
                                                    {0, 1, -kGolden},
                                                    {kGolden, 0, -1},
                                                    {kGolden, 0, 1},
                                                    {-kGolden, 0, -1},
                                                    {-kGolden, 0, 1}}};
  constexpr std::array<formats::Triangle, 20> kFaces = {
      {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
       {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
       {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
  const auto n = static_cast<std::uint32_t>(
      std::max(1L, std::lround(std::sqrt(static_cast<double>(triangles) / kFaces.size()))));
  formats::TriangleMesh mesh;
  // In whole steps from the three corners; the same sum of corners on either side of an edge, to the bit.
  const auto add = [&](std::array<std::pair<std::uint32_t, std::uint32_t>, 3> steps) {
    std::sort(steps.begin(), steps.end());
    transport::Vec3 sum = transport::Vec3::Zero();
    for (const auto& [corner, weight] : steps) sum += static_cast<double>(weight) * corners[corner];
    mesh.positions.push_back(transport::float3(onRippledBall(sum)));
    return static_cast<std::uint32_t>(mesh.positions.size() - 1);
  };
  for (std::uint32_t c = 0; c < corners.size(); ++c) add({{{c, 1}, {c, 0}, {c, 0}}});
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> first_on_edge;
  for (const auto& [a, b, c] : kFaces) {
    for (const auto& [u, v] : {std::minmax(a, b), std::minmax(b, c), std::minmax(c, a)}) {
      if (!first_on_edge.try_emplace({u, v}, static_cast<std::uint32_t>(mesh.positions.size())).second)
        continue;
      for (std::uint32_t k = 1; k < n; ++k) add({{{u, n - k}, {v, k}, {v, 0}}});
    }
  }
  const auto onEdge = [&](std::uint32_t u, std::uint32_t v, std::uint32_t from_u) {
    const std::uint32_t from_least = u < v ? from_u : n - from_u;
    return first_on_edge.at(std::minmax(u, v)) + from_least - 1;
  };
  for (const auto& [a, b, c] : kFaces) {
    // Row i is i steps from a, its place j that many steps from side ab.
    std::vector<std::vector<std::uint32_t>> rows(n + 1);
    for (std::uint32_t i = 0; i <= n; ++i) {
      for (std::uint32_t j = 0; j <= i; ++j) {
        std::uint32_t vertex = 0;
        if (i == 0)
          vertex = a;
        else if (i == n && (j == 0 || j == n))
          vertex = j == 0 ? b : c;
        else if (j == 0)
          vertex = onEdge(a, b, i);
        else if (j == i)
          vertex = onEdge(a, c, i);
        else if (i == n)
          vertex = onEdge(b, c, j);
        else
          vertex = add({{{a, n - i}, {b, i - j}, {c, j}}});
        rows[i].push_back(vertex);
      }
    }
    for (std::uint32_t i = 0; i < n; ++i) {
      for (std::uint32_t j = 0; j <= i; ++j) {
        mesh.triangles.push_back({rows[i][j], rows[i + 1][j], rows[i + 1][j + 1]});
        if (j < i) mesh.triangles.push_back({rows[i][j], rows[i + 1][j + 1], rows[i][j + 1]});
      }
    }
  }
  return mesh;
}

}  // namespace bakelight::tests
