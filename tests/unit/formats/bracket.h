// An L bracket, for meshes of known figures: 20 triangles, 12 vertices, area 18, volume 4, box 3 × 2 × 1.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::formats {

inline TriangleMesh bracket() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0},
                    {0, 0, 1}, {3, 0, 1}, {3, 1, 1}, {1, 1, 1}, {1, 2, 1}, {0, 2, 1}};
  mesh.triangles = {{2, 1, 0},   {3, 2, 0},  {4, 3, 0},  {5, 4, 0},   {6, 7, 8}, {6, 8, 9}, {6, 9, 10},
                    {6, 10, 11}, {0, 1, 7},  {0, 7, 6},  {1, 2, 8},   {1, 8, 7}, {2, 3, 9}, {2, 9, 8},
                    {3, 4, 10},  {3, 10, 9}, {4, 5, 11}, {4, 11, 10}, {5, 0, 6}, {5, 6, 11}};
  return mesh;
}

struct BodyFigures {
  double area = 0, volume = 0;
  Float3 low = {1e30F, 1e30F, 1e30F}, high = {-1e30F, -1e30F, -1e30F};
};

inline BodyFigures figuresOf(const TriangleMesh& mesh) {
  BodyFigures figures;
  for (const Triangle& t : mesh.triangles) {
    const Float3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    double u[3], v[3], n[3];
    for (int k = 0; k < 3; ++k) {
      u[k] = static_cast<double>(b[k]) - a[k];
      v[k] = static_cast<double>(c[k]) - a[k];
      for (const Float3* p : {&a, &b, &c}) {
        figures.low[k] = std::min(figures.low[k], (*p)[k]);
        figures.high[k] = std::max(figures.high[k], (*p)[k]);
      }
    }
    for (int k = 0; k < 3; ++k) n[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
    figures.area += std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / 2;
    figures.volume += (a[0] * n[0] + a[1] * n[1] + a[2] * n[2]) / 6;
  }
  return figures;
}

inline void expectBracket(const TriangleMesh& mesh, const std::string& what) {
  const BodyFigures figures = figuresOf(mesh);
  EXPECT_EQ(mesh.triangles.size(), 20U) << what;
  EXPECT_NEAR(figures.area, 18, 1e-9) << what;
  EXPECT_NEAR(figures.volume, 4, 1e-9) << what;
  EXPECT_EQ(figures.low, (Float3{0, 0, 0})) << what;
  EXPECT_EQ(figures.high, (Float3{3, 2, 1})) << what;
}

// Corner by corner, whatever the numbers of vertices.
inline void expectSameTriangles(const TriangleMesh& mesh, const TriangleMesh& expected,
                                const std::string& what) {
  ASSERT_EQ(mesh.triangles.size(), expected.triangles.size()) << what;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      ASSERT_EQ(mesh.positions[mesh.triangles[t][k]], expected.positions[expected.triangles[t][k]])
          << what << ", triangle " << t << ", corner " << k;
}

}  // namespace bakelight::formats
