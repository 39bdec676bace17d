// Bodies with exact answers, for the survey's tests.
#pragma once

#include <cmath>
#include <numbers>

#include "tests/support/shapes.h"

namespace bakelight::tests {

// Turned about a skew axis, so that no face is along the axes of the coordinates.
inline TriangleMesh turned(TriangleMesh mesh, const Vec3& offset = Vec3::Zero()) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (auto& position : mesh.positions) position = float3(turn * vec3(position) + offset);
  for (auto& normal : mesh.normals) normal = float3(turn * vec3(normal));
  return mesh;
}

// [−1, 1]³, each face divided into 2 · divisions² triangles.
inline TriangleMesh box(int divisions) {
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      const auto base = static_cast<std::uint32_t>(mesh.vertexCount());
      Vec3 normal = Vec3::Zero();
      normal[axis] = side;
      for (int i = 0; i <= divisions; ++i)
        for (int j = 0; j <= divisions; ++j) {
          Vec3 point;
          point[axis] = side;
          point[(axis + 1) % 3] = -1 + 2.0 * i / divisions;
          point[(axis + 2) % 3] = side * (-1 + 2.0 * j / divisions);
          mesh.positions.push_back(float3(point));
          mesh.normals.push_back(float3(normal));
        }
      const auto at = [&](int i, int j) {
        return base + static_cast<std::uint32_t>(i * (divisions + 1) + j);
      };
      for (int i = 0; i < divisions; ++i)
        for (int j = 0; j < divisions; ++j) {
          mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
          mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    }
  return mesh;
}

// The inside of the unit sphere without the cap above height 1 − 2·open_fraction; the rim lies in a plane.
inline TriangleMesh cavity(double open_fraction, int rings, int sides) {
  TriangleMesh mesh;
  const double rim_angle = std::acos(1 - 2 * open_fraction);
  for (int ring = 0; ring <= rings; ++ring) {
    const double angle = rim_angle + (std::numbers::pi - rim_angle) * ring / rings;
    for (int side = 0; side < sides; ++side) {
      const double turn = 2 * std::numbers::pi * side / sides;
      const Vec3 point(std::sin(angle) * std::sin(turn), std::cos(angle), std::sin(angle) * std::cos(turn));
      mesh.positions.push_back(float3(ring == rings ? Vec3(0, -1, 0) : point));
      mesh.normals.push_back(float3(-point));
    }
  }
  const auto at = [&](int ring, int side) { return static_cast<std::uint32_t>(ring * sides + side % sides); };
  for (int ring = 0; ring < rings; ++ring)
    for (int side = 0; side < sides; ++side) {
      mesh.triangles.push_back({at(ring, side), at(ring, side + 1), at(ring + 1, side)});
      if (ring + 1 < rings)
        mesh.triangles.push_back({at(ring, side + 1), at(ring + 1, side + 1), at(ring + 1, side)});
    }
  return mesh;
}

// Area of the regular polygon that is the rim of cavity().
inline double openingArea(double open_fraction, int sides) {
  const double radius = std::sin(std::acos(1 - 2 * open_fraction));
  return sides / 2.0 * radius * radius * std::sin(2 * std::numbers::pi / sides);
}

inline TriangleMesh joined(TriangleMesh whole, const TriangleMesh& part) {
  append(whole, part);
  return whole;
}

}  // namespace bakelight::tests
