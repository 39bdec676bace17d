// A surface with fewer vertices, whatever mesh it came from.
#pragma once

#include "tools/mesomesh/synthesis/surface_graph.h"

namespace bakelight::mesomesh {

struct Coarsening {
  SurfaceGraph coarse;
  std::vector<std::uint32_t> fine_of_coarse;  // coarse vertices are some of the fine ones
  std::vector<Link> parents;                  // of each fine vertex, a link to its nearest coarse one
};

// Keeps a maximal independent set: no two kept vertices are neighbors, and each other vertex has a kept one
// next to it. Which is kept follows from a hash of its number (Luby 1986), about one in 4.3 on a mesh of
// triangles, so that spacing doubles. Coarse vertices are linked where vertices of theirs are, along the mean
// of these ways.
Coarsening coarsened(const SurfaceGraph& fine, std::uint64_t seed);

}  // namespace bakelight::mesomesh
