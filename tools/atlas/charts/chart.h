// One chart: a connected piece of the surface as a mesh of its own.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tools/atlas/charts/surface.h"

namespace bakelight::atlas {

struct Chart {
  std::vector<std::uint32_t> surface_triangles;  // of the surface, ascending
  std::vector<Triangle> triangles;               // of the chart's own vertices, same order
  std::vector<Vec3> positions;                   // of the chart's vertices
  std::vector<std::uint32_t> places;             // of the chart's vertices: the surface's place
  // Loops of vertices along the border, the chart to the left seen from outside; the longest (in length)
  // first. A vertex occurs once in all loops.
  std::vector<std::vector<std::uint32_t>> borders;

  double area = 0;
  // V − E + F: 1 for a disk, 0 for a ring, 2 for a closed sphere.
  std::int64_t euler_characteristic = 0;

  std::size_t vertexCount() const { return positions.size(); }
  bool isDisk() const { return euler_characteristic == 1 && borders.size() == 1; }
  // A disk with holes: what can be laid flat.
  bool isPlanar() const {
    return !borders.empty() && euler_characteristic == 2 - static_cast<std::int64_t>(borders.size());
  }
};

// Triangles hang together across edges that are not cut; a place where two parts of the chart meet at a point
// only, or on both sides of a cut, becomes a vertex for each. `triangles` must be connected and ascending.
// Cost: O(n log n).
Chart chartOf(const Surface& surface, std::span<const std::uint32_t> triangles);

// The connected sets of triangles with one label; cut edges separate. Labels of any values, one a triangle.
// Ordered by their first triangles.
std::vector<std::vector<std::uint32_t>> connectedParts(const Surface& surface,
                                                       std::span<const std::int32_t> labels);
// The same of some triangles, ascending, with one label each.
std::vector<std::vector<std::uint32_t>> connectedParts(const Surface& surface,
                                                       std::span<const std::uint32_t> triangles,
                                                       std::span<const std::int32_t> labels);
// The connected sets of triangles that creases and cuts leave.
std::vector<std::vector<std::uint32_t>> smoothParts(const Surface& surface);

}  // namespace bakelight::atlas
