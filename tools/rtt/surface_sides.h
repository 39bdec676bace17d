// The points of a patch's surface that light is solved at: its vertices, each side that can be seen.
#pragma once

#include <cstdint>
#include <vector>

#include "patch/patch_geometry.h"
#include "transport/surface_points.h"

namespace bakelight::rtt {

// A side is the front of vertex v, numbered v, or its back, v + vertices. Fronts have the rows of their numbers;
// backs follow, of parts with an open border only: the inside of a closed part is dark, and has no row.
struct SurfaceSides {
  static constexpr std::uint32_t kDark = 0xffffffffU;

  std::vector<std::uint32_t> row_of_side;       // 2 × vertices
  std::vector<transport::SurfacePoint> points;  // by row: where rays start, and the normal
  std::vector<formats::Float3> albedo;          // by row
  std::size_t vertices = 0;
};

SurfaceSides surfaceSides(const patch::PatchGeometry& geometry);

}  // namespace bakelight::rtt
