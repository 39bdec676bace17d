// Flat meshes with texture coordinates, a quad at a time.
#pragma once

#include <array>
#include <cstdint>

#include "formats/triangle_mesh.h"

namespace bakelight::tests {

struct Rectangle {
  float left, bottom, right, top;
};

// Two triangles of four new vertices, in the plane z = 0; `place` on the surface, `texture` in the square.
inline void addQuad(formats::TriangleMesh& mesh, const Rectangle& place, const Rectangle& texture) {
  const auto base = static_cast<std::uint32_t>(mesh.vertexCount());
  for (const auto& [right, top] : {std::array{false, false}, {true, false}, {true, true}, {false, true}}) {
    mesh.positions.push_back({right ? place.right : place.left, top ? place.top : place.bottom, 0});
    mesh.texcoords.push_back({right ? texture.right : texture.left, top ? texture.top : texture.bottom});
    mesh.normals.push_back({0, 0, 1});
  }
  mesh.triangles.push_back({base, base + 1, base + 2});
  mesh.triangles.push_back({base, base + 2, base + 3});
}

}  // namespace bakelight::tests
