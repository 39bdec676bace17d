// Meshes made by code, with the normals of the ideal surface.
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>

#include "formats/triangle_mesh.h"
#include "transport/vector_types.h"

namespace bakelight::tests {

using formats::Float3;
using formats::TriangleMesh;
using transport::float3;
using transport::Vec3;
using transport::vec3;

// Appends `part`; its vertices follow those of `whole`.
inline void append(TriangleMesh& whole, const TriangleMesh& part) {
  const auto base = static_cast<std::uint32_t>(whole.vertexCount());
  whole.positions.insert(whole.positions.end(), part.positions.begin(), part.positions.end());
  whole.normals.insert(whole.normals.end(), part.normals.begin(), part.normals.end());
  for (const auto& t : part.triangles) whole.triangles.push_back({base + t[0], base + t[1], base + t[2]});
}

// Icosahedron split `subdivisions` times: 10·4^s + 2 vertices on the sphere, counter-clockwise seen from
// outside.
inline TriangleMesh icosphere(int subdivisions, double radius = 1, const Vec3& center = Vec3::Zero()) {
  const double g = std::numbers::phi;
  std::vector<Vec3> points = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                              {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  for (Vec3& p : points) p.normalize();
  TriangleMesh mesh;
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int s = 0; s < subdivisions; ++s) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [it, is_new] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(points.size()));
      if (is_new) points.push_back((points[a] + points[b]).normalized());
      return it->second;
    };
    std::vector<formats::Triangle> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = finer;
  }
  for (const Vec3& p : points) {
    mesh.positions.push_back(float3(center + radius * p));
    mesh.normals.push_back(float3(p));
  }
  return mesh;
}

inline double surfaceArea(const TriangleMesh& mesh) {
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 ab = vec3(mesh.positions[b]) - vec3(mesh.positions[a]);
    area += ab.cross(vec3(mesh.positions[c]) - vec3(mesh.positions[a])).norm() / 2;
  }
  return area;
}

// The same surface seen from inside: normals and windings turned.
inline TriangleMesh insideOut(TriangleMesh mesh) {
  for (auto& normal : mesh.normals) normal = float3(-vec3(normal));
  for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

// Flat disk around `center`, facing −Y, as a fan of `sides` triangles.
inline TriangleMesh diskFacingDown(const Vec3& center, double radius, int sides) {
  TriangleMesh mesh;
  mesh.positions.push_back(float3(center));
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / sides;
    mesh.positions.push_back(float3(center + radius * Vec3(std::cos(angle), 0, std::sin(angle))));
    mesh.triangles.push_back(
        {0, 1 + static_cast<std::uint32_t>(i), 1 + static_cast<std::uint32_t>((i + 1) % sides)});
  }
  mesh.normals.assign(mesh.positions.size(), {0, -1, 0});
  return mesh;
}

}  // namespace bakelight::tests
