// A mesh with an atlas: every triangle has a place of its own in the unit square.
#pragma once

#include <cstdint>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::atlas {

struct Atlas {
  // With texcoords in [0, 1]; vertices are copied along chart borders, so that each belongs to one chart.
  formats::TriangleMesh mesh;
  std::vector<std::uint32_t> triangle_charts;  // of each triangle: 0 … chart_count − 1
  std::uint32_t chart_count = 0;
};

// The charts of a mesh as its texcoords have them: triangles hang together across an edge whose two ends have
// one position and one texture coordinate each in both, and which they run along in opposite ways. Charts are
// numbered by their first triangles. Throws std::logic_error without texcoords. Cost: O(n log n).
Atlas atlasOf(formats::TriangleMesh mesh);

}  // namespace bakelight::atlas
