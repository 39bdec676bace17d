// Surfaces made by code for the tests of mesomesh.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <string>

#include "formats/triangle_mesh.h"
#include "tests/support/shapes.h"

namespace bakelight::tests {

// columns × rows squares, halved; vertex (i, j) lies at at(i / columns, j / rows). Counter-clockwise where at's
// first argument runs to the right and its second up.
inline TriangleMesh sheet(int columns, int rows, const std::function<Vec3(double, double)>& at) {
  TriangleMesh mesh;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i)
      mesh.positions.push_back(float3(at(static_cast<double>(i) / columns, static_cast<double>(j) / rows)));
  const auto vertex = [&](int i, int j) { return static_cast<std::uint32_t>(j * (columns + 1) + i); };
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
    }
  return mesh;
}

inline TriangleMesh square(int n = 4) {
  return sheet(n, n, [](double u, double v) { return Vec3(u, v, 0); });
}

// Closed: the seam's vertices are doubled, at the same places.
inline TriangleMesh torus(int n = 48, double radius = 1, double tube = 0.4) {
  return sheet(2 * n, n, [&](double u, double v) {
    const double a = 2 * std::numbers::pi * std::fmod(u, 1), b = 2 * std::numbers::pi * std::fmod(v, 1);
    const double r = radius + tube * std::cos(b);
    return Vec3(r * std::cos(a), r * std::sin(a), tube * std::sin(b));
  });
}

inline TriangleMesh mobiusStrip(int n = 40) {
  TriangleMesh mesh = sheet(n, 4, [](double u, double v) {
    const double a = 2 * std::numbers::pi * u, w = 0.3 * (2 * v - 1);
    const double r = 1 + w * std::cos(a / 2);
    return Vec3(r * std::cos(a), r * std::sin(a), w * std::sin(a / 2));
  });
  // Its end meets its start upside down: the same vertices.
  for (auto& triangle : mesh.triangles)
    for (std::uint32_t& v : triangle) {
      const auto row = static_cast<int>(v) / (n + 1);
      if (static_cast<int>(v) % (n + 1) == n) v = static_cast<std::uint32_t>((4 - row) * (n + 1));
    }
  return mesh;
}

// The unit cube as twelve triangles; each side has corners and normals of its own.
inline TriangleMesh cube() {
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      Vec3 n = Vec3::Zero(), u = Vec3::Zero();
      n[axis] = sign, u[(axis + 1) % 3] = 1;
      const Vec3 v = n.cross(u);
      const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
      for (const auto& [a, b] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)}) {
        mesh.positions.push_back(float3((n + a * u + b * v) / 2));
        mesh.normals.push_back(float3(n));
      }
      mesh.triangles.push_back({first, first + 1, first + 2});
      mesh.triangles.push_back({first, first + 2, first + 3});
    }
  return mesh;
}

inline double quality(const TriangleMesh& mesh, std::size_t t) {
  const auto& [a, b, c] = mesh.triangles[t];
  const Vec3 pa = vec3(mesh.positions[a]), pb = vec3(mesh.positions[b]), pc = vec3(mesh.positions[c]);
  const double sides2 = (pb - pa).squaredNorm() + (pc - pb).squaredNorm() + (pa - pc).squaredNorm();
  return sides2 > 0 ? 2 * std::numbers::sqrt3 * (pb - pa).cross(pc - pa).norm() / sides2 : 0;
}

inline double meanQuality(const TriangleMesh& mesh) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t) sum += quality(mesh, t);
  return sum / static_cast<double>(mesh.triangleCount());
}

}  // namespace bakelight::tests
