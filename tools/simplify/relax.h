// Makes the triangles of a decimated mesh round and of similar size, without leaving the original surface.
#pragma once

#include <cstdint>

#include "tools/simplify/half_edge_mesh.h"
#include "tools/simplify/surface_query.h"

namespace bakelight::simplify {

struct RelaxCounts {
  std::int64_t flips = 0;  // edges flipped
  std::int64_t moves = 0;  // vertices moved, over all rounds
};

// Rounds of edge flips (each raises the smallest angle of its two triangles) and of moves of each vertex
// towards the area-weighted centroid of its ring, back onto `original`. No triangle turns over; feature edges
// are not flipped, feature vertices not moved; a flip or move that would take the surface farther than
// `max_deviation` from `original` (at the middle of a new edge) is left out. Serial and in index order, so
// repeatable.
RelaxCounts relax(HalfEdgeMesh& mesh, const SurfaceQuery& original, int rounds, double max_deviation);

// Moves vertices along their normals to fit the original surface best in the least-squares sense, with
// weights that lean towards the worst places: vertices that lie on a curved surface leave their triangles
// wholly inside it. Feature vertices stay. Returns the number of vertices moved.
std::int64_t fit(HalfEdgeMesh& mesh, const SurfaceQuery& original, int rounds);

}  // namespace bakelight::simplify
