// The places of a mesh's vertices, at which light from afar is gathered and spread: hats over triangles.
#pragma once

#include <array>
#include <cstdint>
#include <Eigen/Core>
#include <span>
#include <vector>

#include "formats/triangle_mesh.h"
#include "tools/kernels/point.h"

namespace bakelight::kernels {

struct Knots {
  std::vector<std::uint32_t> of_vertex;    // of the mesh
  std::vector<Vec3> positions;             // in the asset's unit, as all lengths here
  std::vector<Surroundings> surroundings;  // takeSurroundings: empty unless the field is of the surface
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<double> triangle_areas;
  std::vector<double> areas;    // a third of the triangles around each
  std::vector<float> spacings;  // root mean square of the edges around each; 0 without edges
  // The knots around each, itself first, as a list of rows.
  std::vector<std::uint32_t> ring_ends, rings;
  // What hats lose in interpolating, given back: 3/2 − 1/2 (mass matrix ÷ its row sums), for each entry of `rings`. Rows sum to 1. Of a wave of
  // wavenumber k, hats that interpolate its samples leave 1 − c k², and the mass matrix, which is of two hats, 1 − 2 c k² (c = h²/12 for knots h
  // apart on a line, h²/16 on equilateral triangles); so what is sharpened has its amplitude but for the fourth power.
  std::vector<float> sharpening;
  // Triangles around each knot.
  std::vector<std::uint32_t> fan_ends, fans;

  std::size_t count() const { return positions.size(); }
  Point point(std::size_t i) const {
    return {positions[i], surroundings.empty() ? nullptr : &surroundings[i]};
  }
  double meanSpacing() const;  // root mean square of `spacings`
  template <class List>
  static auto row(const List& list, const std::vector<std::uint32_t>& ends, std::size_t i) {
    const std::size_t first = i == 0 ? 0 : ends[i - 1];
    return std::span(list.data() + first, ends[i] - first);
  }
  std::span<const std::uint32_t> ring(std::size_t i) const { return row(rings, ring_ends, i); }
  std::span<const float> sharpeningOf(std::size_t i) const { return row(sharpening, ring_ends, i); }
  std::span<const std::uint32_t> fan(std::size_t i) const { return row(fans, fan_ends, i); }
};

// Vertices at the same place are one knot, in the order of the first of them. Cost: O(n log n).
Knots knotsOf(const formats::TriangleMesh& mesh);

}  // namespace bakelight::kernels
