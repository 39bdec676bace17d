// Meshes with texture coordinates whose figures are known.
#pragma once

#include "formats/triangle_mesh.h"

namespace bakelight::tests {

// The square from (0, 0, 0) to (side, side, 0), facing +Z, with the texture coordinates of `low` to `high`;
// in two triangles, appended.
inline void appendSquare(formats::TriangleMesh& mesh, formats::Float3 corner, float side, formats::Float2 low,
                         formats::Float2 high) {
  const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
  for (const auto& [x, y] : {formats::Float2{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
    mesh.positions.push_back({corner[0] + side * x, corner[1] + side * y, corner[2]});
    mesh.texcoords.push_back({low[0] + x * (high[0] - low[0]), low[1] + y * (high[1] - low[1])});
  }
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
}

inline formats::TriangleMesh texturedSquare(formats::Float2 low, formats::Float2 high) {
  formats::TriangleMesh mesh;
  appendSquare(mesh, {0, 0, 0}, 1, low, high);
  return mesh;
}

}  // namespace bakelight::tests
