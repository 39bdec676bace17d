// Figures of a mesh's texture coordinates: its charts, the room they take, how they stretch.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::inspect {

struct AtlasFigures {
  // Triangles hang together across an edge if both of its ends have one position and one texture coordinate
  // in both, and they run along it in opposite ways. Numbered by their first triangles.
  std::uint32_t charts = 0;
  std::vector<std::uint32_t> triangle_charts;              // of each triangle
  std::vector<std::array<std::uint8_t, 3>> chart_borders;  // 1 where edge k (from corner k on) ends a chart

  // L² stretch of each triangle at the scale that gives the texture the surface's area: more than 1 where it
  // has less texture than its share or an uneven one, less than 1 where it has more. Infinite without any,
  // 1 for a triangle that has no area on the surface.
  std::vector<double> triangle_stretch;
  double l2_stretch = 0;  // of all, area-weighted; 1 for an isometry; infinite if any triangle's is

  double unit_square_share = 0;           // areas summed: more than 1 if charts overlap or leave the square
  std::uint64_t mirrored_charts = 0;      // most of the chart's area is clockwise
  std::uint64_t flipped_triangles = 0;    // the other way round than their chart
  std::uint64_t collapsed_triangles = 0;  // no area in texture coordinates
  std::uint64_t triangles_outside = 0;    // a corner lies outside of [0, 1]²
};

// `mesh` has texture coordinates. Cost: O(n log n).
AtlasFigures measureAtlas(const formats::TriangleMesh& mesh);

// One of `count` numbers for each chart: charts that meet along an edge of the surface get different ones
// where that many suffice, and each number is used about as often.
std::vector<std::uint32_t> alternateNumbers(const formats::TriangleMesh& mesh, const AtlasFigures& figures,
                                            std::uint32_t count);

}  // namespace bakelight::inspect
