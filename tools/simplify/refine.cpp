#include "tools/simplify/refine.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>

namespace bakelight::simplify {

std::int64_t splitLongEdges(CornerMesh& mesh, double max_length, std::int64_t max_splits) {
  double longest = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, mesh.opposite.size()), 0.0,
      [&](const tbb::blocked_range<std::size_t>& sides, double greatest) {
        for (std::size_t s = sides.begin(); s < sides.end(); ++s)
          greatest = std::max(greatest, mesh.length(static_cast<Side>(s)));
        return greatest;
      },
      [](double a, double b) { return std::max(a, b); });
  std::int64_t splits = 0;
  while (longest > max_length && splits < max_splits) {
    const double length = std::max(longest / 2, max_length);
    for (Side s = 0; s < mesh.opposite.size() && splits < max_splits; ++s) {
      if (!mesh.isEdge(s) || mesh.length(s) <= length) continue;
      mesh.splitEdge(s, (mesh.positions[mesh.start(s)] + mesh.positions[mesh.end(s)]) / 2);
      ++splits;
    }
    longest = length;
  }
  return splits;
}

}  // namespace bakelight::simplify
