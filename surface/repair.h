// Turns triangle soup into an oriented two-manifold (with border, perhaps) that a half-edge structure
// accepts, and counts what it did.
#pragma once

#include <cstdint>
#include <vector>

#include "surface/working_mesh.h"

namespace bakelight::surface {

// Every count is 0 for a clean mesh.
struct RepairCounts {
  std::int64_t welded_vertices = 0;  // merged into an earlier vertex
  std::int64_t repeated_index_triangles =
      0;                                 // removed: two of the three corners are one vertex (after the weld)
  std::int64_t duplicate_triangles = 0;  // removed: same corners, same orientation as an earlier triangle
  std::int64_t reversed_triangles = 0;   // removed: same corners, opposite orientation
  std::int64_t lost_backs = 0;           // such as could have been seen: not the inside of a closed part
  std::int64_t sheet_triangles = 0;  // such as are kept as the backs of whole sheets (WorkingMesh::sheets)
  std::int64_t zero_area_triangles = 0;  // removed or flipped away: height below kNeedleHeight × longest edge
  std::int64_t kept_needles = 0;         // such triangles that no collapse or flip could remove
  std::int64_t non_manifold_edges = 0;   // shared by more than two triangles; cut or paired
  std::int64_t non_manifold_vertices = 0;  // joining several fans; one copy a fan
  std::int64_t added_vertices = 0;         // by those splits
  std::int64_t reoriented_triangles = 0;   // turned to agree with their neighbours
  std::int64_t one_sided_cuts = 0;         // edges cut as no orientation agrees across them (Möbius strips)
  std::int64_t inside_out_components = 0;  // closed, and turned as a whole (inside_out.h)
  std::int64_t isolated_vertices = 0;      // removed: used by no triangle

  bool clean() const;
};

// Triangles flatter than this (height ÷ longest edge) carry no area worth keeping.
inline constexpr double kNeedleHeight = 1e-5;

// Welds vertices closer than `weld_tolerance` (≥ 0, in units of the mesh; 0 merges exactly coincident ones),
// then mends in the order of RepairCounts. May leave no triangle at all. Indices must be in range, positions
// finite. Where all triangles of an open part lie back to back on others, one of each two stays and stands
// for both, so that leaves and cloth keep two sides that fit each other. The order of surviving triangles and
// vertices is kept. Cost: O(n log n).
RepairCounts repair(WorkingMesh& mesh, double weld_tolerance);

// For each vertex the one that the weld merges it into, often itself.
std::vector<std::uint32_t> weldedVertices(const std::vector<Vec3>& positions, double weld_tolerance);

struct Topology {
  std::int64_t components = 0;            // connected through shared edges
  std::int64_t boundary_edges = 0;        // in one triangle only
  std::int64_t euler_characteristic = 0;  // vertices − edges + triangles
  bool closed() const { return boundary_edges == 0; }
};
// `mesh` must be repaired.
Topology topology(const WorkingMesh& mesh);

}  // namespace bakelight::surface
