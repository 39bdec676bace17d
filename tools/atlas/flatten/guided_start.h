// A flat start for a chart from how its triangles lay in flat charts before: those of a proxy, of which it is
// the detail, of a larger one that was divided, or of two that are to be one.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tools/atlas/charts/chart.h"
#include "tools/atlas/charts/surface.h"

namespace bakelight::atlas {

// For each triangle of a surface the direction of its edge 0 in the plane that it was laid flat in last, of
// unit length: of the rotation that is nearest to how it lay there.
struct Guides {
  std::vector<Vec2> directions;
  std::vector<std::int32_t> planes;  // which; −1: none yet. Directions of one plane belong together.

  bool empty() const { return planes.empty(); }
  void set(std::span<const std::uint32_t> triangles, std::span<const Vec2> triangle_directions,
           std::int32_t plane);
};

// The directions of a chart's triangles in a plane.
std::vector<Vec2> directionsIn(const Chart& chart, std::span<const Vec2> plane);

// The direction of a triangle that is as good as that of another of about the same place and normal.
Vec2 directionBeside(const Surface& surface, std::uint32_t triangle, const Surface& other_surface,
                     std::uint32_t other, const Vec2& direction_of_other);

// The plane whose triangles are nearest to their own shapes turned into the directions of `guides` (planes
// turned such that edges between them agree), and then to any directions (Liu et al. 2008, local and global
// phases), for a few rounds. Nothing if a triangle has no guide or is flipped after that. Cost: one sparse
// factorisation of as many unknowns as the chart has vertices.
std::optional<std::vector<Vec2>> guidedStart(const Surface& surface, const Chart& chart,
                                             const Guides& guides);

}  // namespace bakelight::atlas
