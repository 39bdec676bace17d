// Neighborhood transfer of a diffuse object (Sloan, Kautz & Snyder 2002, section 8): at points around it, the linear map from distant light to
// incident radiance. Pure: structs in, structs out.
//
//   M_ij = ∫ y_i(s) [V(s) y_j(s) + (1 − V(s)) ρ T_j(hit)] ds = δ_ij + ∫ y_i(s) (1 − V(s)) [ρ T_j(hit) − y_j(s)] ds
//
// V: nothing lies along s from the point; T_j: what the object sends out for unit light y_j where s meets it, as `transfer` baked it, interpolated, so
// with the object's own shadows and bounces; ρ: its albedo there. The integral over what is hit is stored. The object does not see its receivers.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "formats/triangle_mesh.h"
#include "tools/neighborhood/grid.h"
#include "tools/stage/progress.h"

namespace bakelight::neighborhood {

struct Emitted {
  int order = 0;
  int channels = 1;  // of the result, too: 3 where the albedo or the vectors are coloured
  std::vector<float>
      vectors;  // vertices × (channels · order²): radiance that leaves a vertex per unit coefficient, albedo inside
};
// From a transfer stage's diffuse vectors (`baked_channels` of them, without albedo) and the albedo of each vertex, or one for all.
Emitted emittedBy(std::span<const float> transfer, int order, int baked_channels, std::size_t vertices,
                  std::span<const formats::Float3> albedo);

struct Options {
  int directions = 512;  // rays a point, over the directions in which the object may be
};

struct Table {
  std::vector<float> values;  // a row a point
  std::uint64_t rays = 0, hits = 0;
  std::uint64_t inside_points = 0;  // of a volume: inside the object, filled in from their neighbors
};

// Both are deterministic whatever the threads; `progress` advances by one a point. Cost: points × directions rays.
//
// Rows as formats::GroundTransfer has them. What lies under the object, where rays meet its surface from inside, is dark.
Table groundTransfer(const formats::TriangleMesh& mesh, const Emitted& emitted, const GroundGrid& grid,
                     const Options& options, stage::Progress& progress);
// Rows as formats::VolumeTransfer has them; zero in the outermost points but the lowest, so that nothing shows where the grid ends.
Table volumeTransfer(const formats::TriangleMesh& mesh, const Emitted& emitted,
                     const std::array<std::vector<float>, 3>& axes, const Options& options,
                     stage::Progress& progress);

}  // namespace bakelight::neighborhood
