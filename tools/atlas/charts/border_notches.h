// Teeth and notches of a jagged border that is to lie along straight sides.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tools/atlas/charts/chart.h"

namespace bakelight::atlas {

// The outer border with the path lengths from its first vertex; the last is the whole length.
struct BorderPath {
  const std::vector<std::uint32_t>& vertices;
  std::vector<double> length_to;

  explicit BorderPath(const Chart& chart) : vertices(chart.borders.front()), length_to{0} {
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const Vec3& next = chart.positions[vertices[(i + 1) % vertices.size()]];
      length_to.push_back(length_to.back() + (next - chart.positions[vertices[i]]).norm());
    }
  }
  std::uint32_t size() const { return static_cast<std::uint32_t>(vertices.size()); }
  // Of vertex i, which may have gone around once.
  double at(std::uint32_t i) const {
    return i < size() ? length_to[i] : length_to.back() + length_to[i - size()];
  }
};

// The border between two corners, as indices into it; `end` is larger than `begin` and may be past the
// border's end.
struct Side {
  std::uint32_t begin, end;
  double length;
};

// A triangle that lies between a reentrant vertex of the border and the polygon, with the shape that it has
// there if the border keeps its own.
struct NotchTriangle {
  Triangle vertices;          // of the chart
  std::array<Vec2, 3> shape;  // counter-clockwise
};

struct Notches {
  std::vector<std::uint8_t> inside;  // of the border's vertices: 1 behind a notch, off the border
  std::vector<NotchTriangle> triangles;
  std::vector<std::uint8_t> sides_with_chords;  // 1: an inner edge still joins two of the side's vertices
};

// Fills notches until no inner edge joins two vertices of one side, where it can: one of the two ends goes
// inside if it is no corner, and if the border is reentrant there or about straight at the foot of a tooth of
// a few edges. The most reentrant vertex goes first. `sides` follow each other around the border of `chart`.
// Cost: O(n log n) of the border, O(triangles).
Notches fillNotches(const Chart& chart, const BorderPath& path, const std::vector<Side>& sides);

}  // namespace bakelight::atlas
