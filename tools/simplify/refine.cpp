#include "tools/simplify/refine.h"

#include <queue>
#include <utility>
#include <vector>

#include "surface/parallel_lists.h"
#include "tools/simplify/surface_words.h"

namespace bakelight::simplify {

std::int64_t splitLongEdges(CornerMesh& mesh, double max_length, std::int64_t max_splits) {
  // The longest of all is always the next: otherwise the triangles beside a longer one never become short.
  std::priority_queue<std::pair<double, Side>> longest;
  const auto add = [&](Side s) {
    const double length = mesh.length(s);
    if (length > max_length) longest.push({length, s});
  };
  for (const Side s : filtered(mesh.opposite.size(), [&](std::size_t i) {
         const auto side = static_cast<Side>(i);
         return mesh.isEdge(side) && mesh.length(side) > max_length;
       }))
    add(s);
  std::int64_t splits = 0;
  while (!longest.empty() && splits < max_splits) {
    const auto [length, side] = longest.top();
    longest.pop();
    if (mesh.length(side) != length) continue;  // another edge is there by now; it has its own entry
    const Side other = mesh.opposite[side];
    const auto first_added = static_cast<Side>(mesh.opposite.size());
    mesh.splitEdge(side, (mesh.positions[mesh.start(side)] + mesh.positions[mesh.end(side)]) / 2);
    ++splits;
    add(side);
    add(nextSide(side));
    if (other != kNone) add(nextSide(other));
    for (Side s = first_added; s < mesh.opposite.size(); ++s) add(s);
  }
  return splits;
}

}  // namespace bakelight::simplify
