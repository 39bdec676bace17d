// Judges any mesh with texture coordinates as an atlas.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/atlas/atlas.h"

namespace bakelight::atlas {

struct AtlasFigures {
  std::int64_t charts = 0, triangles = 0;
  // Defects.
  std::int64_t flipped =
      0;  // triangles of negative orientation (exact); if all are, the atlas is mirrored: counted, too
  std::int64_t collapsed = 0;  // triangles with an area on the surface and none in the plane (exact)
  std::int64_t overlapping_texels =
      0;  // centres that lie in more than one triangle, by the top-left rule (exact)
  std::int64_t crossing_edges =
      0;  // pairs of chart border edges, of one chart or two, that cross or overlap (exact)
  std::int64_t outside = 0;  // vertices outside [0, 1]
  std::int64_t defects() const { return flipped + collapsed + overlapping_texels + crossing_edges + outside; }
  // Figures at the resolution.
  int resolution = 0;
  double utilisation = 0;   // share of all texels whose centre lies in a triangle
  double touched = 0;       // share of texels that any triangle overlaps
  int smallest_gutter = 0;  // texels: free ones between any two that different charts overlap; −1: one texel
                            // is shared; `resolution` if there is one chart
  std::int64_t triangles_below_texel = 0;         // area in the plane less than a texel
  std::int64_t triangles_without_texel = 0;       // no centre in them
  double l2_stretch = 0, l_infinity_stretch = 0;  // over all charts at one scale, see stretch.h
  double mean_anisotropy = 0;
  double worst_chart_l2 = 0;
  double texel_density_spread = 0;  // largest ÷ smallest √(plane area ÷ surface area) of charts
  double border_length = 0;         // of all charts ÷ √(surface area)
};

// Exact where it says so: orientation by CGAL's predicates on the float coordinates. Cost: O(n log n +
// texels). Throws Error(kBadInput) naming `file` if the mesh has no texture coordinates.
AtlasFigures check(const Atlas& atlas, int resolution, const std::string& file);

}  // namespace bakelight::atlas
