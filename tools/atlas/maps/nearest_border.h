// The nearest point of a chart's border, for texels beside it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tools/atlas/charts/surface.h"
#include "tools/atlas/maps/texture_edges.h"

namespace bakelight::atlas {

// A border edge, in texels.
struct TexelBorder {
  TextureEdge edge;
  std::int32_t chart;
  Vec2 from, to;  // from corner k of the triangle to the next
  Vec2 outward;   // unit length, at right angles, away from the triangle
  double length;
};
// Ascending by triangle and edge; edges without a length, or of triangles without an area, are left out.
std::vector<TexelBorder> texelBorders(const formats::TriangleMesh& mesh,
                                      std::span<const std::uint32_t> triangle_charts, int resolution);

struct BorderPoint {
  std::int32_t border = -1;  // index, −1: none within reach
  double along = 0;          // share of the way from its beginning
};

// For texels whose `charts` entry is a chart and that have no `center_triangles` entry: the point of that
// chart's border nearest to their centre, if it is nearer than `reach` texels. Of two edges that meet in that
// point the one beyond which the centre lies more; of equal ones the first. Cost: Σ edges · reach · (reach +
// length); threads by TBB, same bits for any number.
std::vector<BorderPoint> nearestBorders(std::span<const TexelBorder> borders, int resolution, double reach,
                                        std::span<const std::int32_t> charts,
                                        std::span<const std::int32_t> center_triangles);

}  // namespace bakelight::atlas
