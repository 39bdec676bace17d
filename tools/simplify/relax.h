// Makes the triangles of a decimated mesh round while they keep fitting the original surface.
#pragma once

#include <cstddef>
#include <cstdint>

#include "surface/corner_mesh.h"
#include "tools/simplify/surface_words.h"
#include "transport/surface_query.h"

namespace bakelight::simplify {

struct RelaxCounts {
  std::int64_t flips = 0;  // edges flipped
  std::int64_t moves = 0;  // vertices moved, over all rounds
};

// Mesh optimisation after Hoppe et al. 1993: local operations, each of which lowers one cost
//
//   Σ_samples (e + e⁴/k³) / (samples a triangle)  +  w · Σ_triangles (q + q³),     e = d²/σ²,  q =
//   1/roundness − 1
//
// where d is the distance of a point of the original surface from the mesh, σ the rms of d and roundness
// 4√3·area/Σ(side²). An edge is flipped, or a vertex is moved towards the centroid of its ring (tangentially)
// and to the height at which it fits the samples around it best. No triangle turns by more than 35° at once,
// unless that unfolds it; feature edges and vertices (features.h) stay, and no vertex strays farther than a
// few σ from the original. Vertices of one color (no two of them neighbours) move at once, edges flip at once
// where their quadrilaterals have no corner in common: all TBB threads, the same bytes for any number of
// them. Adds vertices where the fit is worst after half of the rounds: `insert_triangles` more triangles, or
// one fewer. `mesh` must be compact. Cost: about 0.2 s of one core a round for 20k
// triangles.
RelaxCounts relax(CornerMesh& mesh, const SurfaceQuery& original, int rounds, std::size_t insert_triangles);

}  // namespace bakelight::simplify
