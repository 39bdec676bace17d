// Transfer in a pixel basis made by code.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <random>
#include <vector>

#include "formats/pixel_transfer.h"
#include "transport/cube_map.h"
#include "transport/hemisphere_grid.h"

namespace bakelight::tests {

using formats::PixelRows;
using transport::Vec3;

// What an open vertex sees: texels by the cell of the hemisphere about `normal`, fractions along the horizon and along the edge of
// a blocker, a cone.
inline void addVertex(PixelRows& rows, const Vec3& normal, const Vec3& tangent, const Vec3& blocker,
                      double blocker_cosine) {
  const Vec3 bitangent = normal.cross(tangent);
  const int side = rows.cube_side, local = rows.local_side, sub = rows.subsamples;
  std::vector<std::map<std::uint16_t, std::uint8_t>> cells(static_cast<std::size_t>(local) * local);
  for (int k = 0; k < 6 * side * side; ++k) {
    const int x = k % side, y = k / side % side, face = k / side / side;
    std::uint8_t code = 0;
    for (int s = 0; s < sub * sub; ++s) {
      const Vec3 d = transport::directionOfCubeFace(face, (x + (s % sub + 0.5) / sub) / side,
                                                    (y + (s / sub + 0.5) / sub) / side);
      if (d.dot(normal) > 0 && d.dot(blocker) < blocker_cosine) ++code;
    }
    if (code == 0) continue;
    const Vec3 d = transport::directionOfCubeFace(face, (x + 0.5) / side, (y + 0.5) / side);
    const transport::SquarePoint p =
        transport::squareFromHemisphere(Vec3(d.dot(tangent), d.dot(bitangent), d.dot(normal)));
    const int column = std::min(local - 1, static_cast<int>(p.a * local)),
              row = std::min(local - 1, static_cast<int>(p.b * local));
    cells[static_cast<std::size_t>(row) * local + column][static_cast<std::uint16_t>(k)] = code;
  }
  for (const auto& cell : cells) {
    for (const auto& [column, code] : cell) rows.columns.push_back(column), rows.codes.push_back(code);
    rows.row_offsets.push_back(rows.columns.size());
  }
}

inline PixelRows emptyRows(int cube_side, int local_side, int subsamples) {
  PixelRows rows;
  rows.cube_side = cube_side, rows.local_side = local_side, rows.subsamples = subsamples;
  return rows;
}

inline PixelRows ballRows(int vertices, int cube_side, int local_side, int subsamples,
                          double blocker_cosine = 0.8, bool flip = false) {
  PixelRows rows = emptyRows(cube_side, local_side, subsamples);
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int v = 0; v < vertices; ++v) {
    const Vec3 n = Vec3(normal(random), normal(random), normal(random)).normalized();
    Vec3 t = n.cross(Vec3(normal(random), normal(random), normal(random))).normalized();
    if (flip && v % 2 == 1) t = -t;
    addVertex(rows, n, t, Vec3(0, 1, 0), blocker_cosine);
  }
  return rows;
}

inline PixelRows noiseRows(int rows_wanted, int most_entries, int cube_side, int subsamples) {
  PixelRows rows = emptyRows(cube_side, 1, subsamples);
  std::mt19937 random(11);
  for (int row = 0; row < rows_wanted; ++row) {
    std::map<std::uint16_t, std::uint8_t> entries;
    const int count = static_cast<int>(random() % (most_entries + 1));
    for (int i = 0; i < count; ++i)
      entries[static_cast<std::uint16_t>(random() % (6 * cube_side * cube_side))] =
          static_cast<std::uint8_t>(1 + random() % (subsamples * subsamples));
    for (const auto& [column, code] : entries) rows.columns.push_back(column), rows.codes.push_back(code);
    rows.row_offsets.push_back(rows.columns.size());
  }
  return rows;
}

inline bool sameRows(const PixelRows& a, const PixelRows& b) {
  return a.row_offsets == b.row_offsets && a.columns == b.columns && a.codes == b.codes;
}

}  // namespace bakelight::tests
