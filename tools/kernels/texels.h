// The texels of an atlas that light falls on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "tools/kernels/knots.h"

namespace bakelight::kernels {

struct Texels {
  int resolution = 0;
  std::vector<std::uint32_t> places;  // row · resolution + column, ascending
  std::vector<std::uint32_t> triangles;
  std::vector<Eigen::Array3f> weights;  // of the triangle's corners
  std::vector<Eigen::Vector3f> positions, normals;
  std::vector<Surroundings> surroundings;  // takeSurroundings: empty unless the field is of the surface
  std::vector<std::uint32_t> charts;
  std::vector<float> areas;  // of the surface in each, once: 0 beyond the edge of a chart
  std::vector<float> cells;  // of the surface around each, as a whole texel where the surface goes on
  std::vector<float> sides;  // length of a texel there, > 0
  // Along a step to the right, and to the row below, over the surface.
  std::vector<Eigen::Vector3f> across, down;
  std::vector<std::int32_t> index_of;  // of a place: index here; −1 none

  std::size_t count() const { return places.size(); }
  Point point(std::size_t i) const {
    return {positions[i].cast<double>(), surroundings.empty() ? nullptr : &surroundings[i]};
  }
  // That so many to the right and below, if it shows the same chart or what lies beyond its edge; −1: none.
  std::int32_t neighbour(std::size_t of, int dx, int dy) const {
    const int x = static_cast<int>(places[of]) % resolution + dx,
              y = static_cast<int>(places[of]) / resolution + dy;
    if (x < 0 || y < 0 || x >= resolution || y >= resolution) return -1;
    const std::int32_t found = index_of[static_cast<std::size_t>(y) * resolution + x];
    return found >= 0 && charts[static_cast<std::size_t>(found)] == charts[of] ? found : -1;
  }
};

inline constexpr int kBorder = 4;  // texels: 3 for a kernel, 1 for what bilinear lookups take beside a chart
// Of the geometry maps that atlas wrote for the mesh. Throws Error(kBadInput) naming file and texel: channels that are missing, another
// mesh's maps, no square, nothing covered; and where charts meet, a border of less than kBorder texels, over which kernels could not see.
Texels texelsOf(const std::filesystem::path& maps, const formats::TriangleMesh& mesh, const Knots& knots);

// What the mesh's colors are around each knot and texel, where `field`, which was made of that mesh, is of the surface.
void takeSurroundings(const transport::MediumField& field, const formats::TriangleMesh& mesh, Knots& knots,
                      Texels& texels);

}  // namespace bakelight::kernels
