// The edges of a mesh as its texture coordinates have them: what hangs together in the plane, and borders.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::atlas {

// Edge k of a triangle runs from its corner k to corner (k + 1) % 3.
struct TextureEdge {
  std::uint32_t low,
      high;  // its ends: vertices that stand for all at one position with one texture coordinate
  std::uint32_t triangle;
  std::uint8_t edge;
  bool upwards;  // the triangle runs from low to high
};

// All uses of one edge at a time, ascending by triangle. Edges whose ends are one are left out. Needs
// texcoords. Cost: O(n log n).
void forEachTextureEdge(const formats::TriangleMesh& mesh,
                        const std::function<void(std::span<const TextureEdge>)>& visit);

// As many triangles run along it one way as the other.
bool isInner(std::span<const TextureEdge> uses);

// Of charts: the edges that are not inner. Ascending by triangle and edge.
std::vector<TextureEdge> borderEdges(const formats::TriangleMesh& mesh);

}  // namespace bakelight::atlas
