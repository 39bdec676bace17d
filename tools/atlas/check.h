// Judges any mesh with texture coordinates as an atlas.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/atlas/atlas.h"

namespace bakelight::atlas {

// More pairs of crossing edges than this are not counted.
inline constexpr std::int64_t kMostCrossings = 1000000;

struct AtlasFigures {
  std::int64_t charts = 0, triangles = 0;
  // Defects; exact, whatever the resolution, but for the texels.
  std::int64_t flipped = 0;    // triangles that turn against their chart, of which the larger area decides
  std::int64_t collapsed = 0;  // triangles with an area on the surface and none in the plane
  std::int64_t overlapping_texels = 0;  // centres in more than one triangle, by the top-left rule
  std::int64_t crossing_edges = 0;      // pairs of border edges that run into charts, see bordersCross()
  std::int64_t outside = 0;             // vertices of triangles that do not lie in [0, 1]²
  std::int64_t defects() const { return flipped + collapsed + overlapping_texels + crossing_edges + outside; }

  // Charts that turn clockwise. No defect: a frame with a handedness is right on them, too.
  std::int64_t mirrored_charts = 0;

  // At the resolution.
  int resolution = 0;
  double utilisation = 0;  // share of texels whose centre lies in a triangle
  double touched = 0;      // share of texels whose inside meets a triangle that has an area in the plane
  // Free texels between any two that different charts touch, in row, column and diagonal; −1: they share one;
  // `resolution` if there is one chart.
  int smallest_gutter = 0;
  std::int64_t triangles_below_texel = 0;    // area in the plane less than a texel
  std::int64_t triangles_without_texel = 0;  // no centre in them

  // Of triangles that have an area on the surface, and are neither flipped nor collapsed. 0 if there is none.
  double l2_stretch = 0, l_infinity_stretch = 0;  // over all charts at one scale, see stretch.h
  double mean_anisotropy = 0;
  double worst_chart_l2 = 0;        // at the chart's own scale
  double texel_density_spread = 0;  // largest ÷ smallest √(plane area ÷ surface area) of charts
  double border_length = 0;         // of all charts, so that a seam counts twice, ÷ √(surface area)
};

// Throws Error(kBadInput) naming `file`: no texture coordinates; whatever surfaceOf() throws, as no triangle
// has an area. Cost: O(n log n + texels).
AtlasFigures check(const Atlas& atlas, int resolution, const std::string& file);

}  // namespace bakelight::atlas
