#include "tools/simplify/refine.h"

#include <algorithm>

namespace bakelight::simplify {

std::int64_t splitLongEdges(HalfEdgeMesh& mesh, double max_length, std::int64_t max_splits) {
  double longest = 0;
  for (const auto edge : mesh.edges()) longest = std::max(longest, mesh.calc_edge_length(edge));
  std::int64_t splits = 0;
  while (longest > max_length && splits < max_splits) {
    const double length = std::max(longest / 2, max_length);
    for (int e = 0; e < static_cast<int>(mesh.n_edges()) && splits < max_splits; ++e) {
      const EdgeHandle edge = mesh.edge_handle(static_cast<unsigned>(e));
      if (mesh.calc_edge_length(edge) <= length) continue;
      splitEdge(mesh, edge, mesh.calc_edge_midpoint(edge));
      ++splits;
    }
    longest = length;
  }
  return splits;
}

}  // namespace bakelight::simplify
