// Closed and twisted bodies, made by code.
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "tests/support/shapes.h"

namespace bakelight::tests {

// Grid of `around` × `along` quads, cut in two, at the positions place(i, j) gives; wrapped around in the
// first, and in the second on request.
template <class Place>
TriangleMesh wrappedGrid(std::uint32_t around, std::uint32_t along, bool wraps_along, const Place& place) {
  TriangleMesh mesh;
  const std::uint32_t rows = wraps_along ? along : along + 1;
  for (std::uint32_t j = 0; j < rows; ++j)
    for (std::uint32_t i = 0; i < around; ++i) mesh.positions.push_back(float3(place(i, j)));
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return (j % rows) * around + i % around; };
  for (std::uint32_t j = 0; j < along; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

inline TriangleMesh torus(std::uint32_t around, std::uint32_t along, double radius, double tube) {
  return wrappedGrid(around, along, true, [=](std::uint32_t i, std::uint32_t j) {
    const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * j / along;
    return Vec3((radius + tube * std::cos(v)) * std::cos(u), (radius + tube * std::cos(v)) * std::sin(u),
                tube * std::sin(v));
  });
}

// A cylinder without caps, around z.
inline TriangleMesh tube(std::uint32_t around, std::uint32_t along, double radius, double height) {
  return wrappedGrid(around, along, false, [=](std::uint32_t i, std::uint32_t j) {
    const double u = 2 * std::numbers::pi * i / around;
    return Vec3(radius * std::cos(u), radius * std::sin(u), height * j / along);
  });
}

// A slab with `holes` square holes in a row: a closed surface of that genus. Each unit square of its skin is
// divided `divisions` times, then the skin is smoothed, so that no edge is a crease.
inline TriangleMesh slabWithHoles(int holes, int divisions, int smoothing) {
  const int length = (2 * holes + 1) * divisions, width = 3 * divisions, height = divisions;
  const auto isSolid = [&](int x, int y, int z) {
    if (x < 0 || y < 0 || z < 0 || x >= length || y >= width || z >= height) return false;
    return !((x / divisions) % 2 == 1 && y / divisions == 1);
  };
  TriangleMesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> index;
  const auto vertex = [&](std::array<int, 3> p) {
    const auto [it, is_new] = index.try_emplace(p, static_cast<std::uint32_t>(mesh.positions.size()));
    if (is_new)
      mesh.positions.push_back({static_cast<float>(p[0]) / static_cast<float>(divisions),
                                static_cast<float>(p[1]) / static_cast<float>(divisions),
                                static_cast<float>(p[2]) / static_cast<float>(divisions)});
    return it->second;
  };
  for (int x = 0; x < length; ++x)
    for (int y = 0; y < width; ++y)
      for (int z = 0; z < height; ++z) {
        if (!isSolid(x, y, z)) continue;
        for (std::size_t axis = 0; axis < 3; ++axis)
          for (const int side : {0, 1}) {
            std::array<int, 3> beyond = {x, y, z};
            beyond[axis] += side == 1 ? 1 : -1;
            if (isSolid(beyond[0], beyond[1], beyond[2])) continue;
            // Counter-clockwise seen from `beyond`.
            std::array<std::uint32_t, 4> quad{};
            for (int c = 0; c < 4; ++c) {
              std::array<int, 3> p = {x, y, z};
              p[axis] += side;
              p[(axis + 1) % 3] += c == 1 || c == 2;
              p[(axis + 2) % 3] += c >= 2;
              quad[static_cast<std::size_t>(side == 1 ? c : 3 - c)] = vertex(p);
            }
            mesh.triangles.push_back({quad[0], quad[1], quad[2]});
            mesh.triangles.push_back({quad[0], quad[2], quad[3]});
          }
      }
  std::vector<std::set<std::uint32_t>> neighbors(mesh.vertexCount());
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) neighbors[t[k]].insert({t[(k + 1) % 3], t[(k + 2) % 3]});
  for (int round = 0; round < smoothing; ++round) {
    std::vector<Float3> next;
    for (const auto& around : neighbors) {
      Vec3 sum = Vec3::Zero();
      for (const std::uint32_t v : around) sum += vec3(mesh.positions[v]);
      next.push_back(float3(sum / static_cast<double>(around.size())));
    }
    mesh.positions = next;
  }
  return mesh;
}

// One side of a Möbius strip, so that its triangles cannot all agree on an orientation: one seam of edges
// that two triangles run along the same way.
inline TriangleMesh moebiusStrip(std::uint32_t around, std::uint32_t across) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j <= across; ++j) {
      const double u = 2 * std::numbers::pi * i / around, w = 0.8 * j / across - 0.4;
      const double radius = 1 + w * std::cos(u / 2);
      mesh.positions.push_back(float3(Vec3(radius * std::cos(u), radius * std::sin(u), w * std::sin(u / 2))));
    }
  const auto at = [&](std::uint32_t i, std::uint32_t j) {
    return i < around ? i * (across + 1) + j : across - j;
  };
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < across; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

// A flat staircase spiralling down around the z axis, `turns` times: laid flat, its turns lie on each other.
inline TriangleMesh spiralRibbon(double turns, std::uint32_t steps) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i <= steps; ++i)
    for (const double radius : {0.5, 1.0}) {
      const double u = 2 * std::numbers::pi * turns * i / steps;
      mesh.positions.push_back(float3(Vec3(radius * std::cos(u), radius * std::sin(u), 0.02 * u)));
    }
  for (std::uint32_t i = 0; i < steps; ++i) {
    mesh.triangles.push_back({2 * i, 2 * i + 1, 2 * i + 3});
    mesh.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 2});
  }
  return mesh;
}

// `count` separate triangles.
inline TriangleMesh confetti(std::uint32_t count) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double x = i % 317, y = static_cast<double>(i) / 317, turn = i * 0.7;
    for (int k = 0; k < 3; ++k) {
      const double angle = turn + 2 * std::numbers::pi * k / 3, radius = 0.3 + 0.1 * std::sin(i + 2.0 * k);
      mesh.positions.push_back(
          float3(Vec3(x + radius * std::cos(angle), y + radius * std::sin(angle), std::sin(i * 0.1))));
    }
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

}  // namespace bakelight::tests
