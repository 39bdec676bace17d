#include "tools/mesomesh/retile/subdivision.h"

#include <tbb/parallel_for.h>

#include "surface/parallel_lists.h"

namespace bakelight::mesomesh {

SlidingMesh subdivided(const SlidingMesh& sliding) {
  const CornerMesh& from = sliding.mesh;
  const std::size_t old_count = from.positions.size(), triangle_count = from.triangles.size();
  const std::vector<Side> edges = surface::filtered(
      from.opposite.size(), [&](std::size_t s) { return from.isEdge(static_cast<Side>(s)); });
  const std::size_t count = old_count + edges.size();

  SlidingMesh result{CornerMesh(transport::SurfaceMesh{}), sliding.curve, sliding.near, sliding.segment};
  CornerMesh& to = result.mesh;
  to.positions = from.positions;
  to.feature = from.feature, to.locked = from.locked, to.leaving = from.leaving;
  to.positions.resize(count), to.feature.resize(count, 0), to.locked.resize(count, 0);
  to.leaving.resize(count, kNone), result.curve.resize(count, kNone), result.near.resize(count, 0),
      result.segment.resize(count, 0);
  to.triangles.resize(4 * triangle_count), to.materials.resize(4 * triangle_count);
  to.opposite.assign(12 * triangle_count, kNone), to.side_feature.assign(12 * triangle_count, 0);

  // Halves of a parent's side k: from its start, in the child at corner k, and to its end, in the next one.
  const auto firstHalf = [](Side s) { return 3 * (4 * (s / 3) + s % 3); };
  const auto secondHalf = [](Side s) { return 3 * (4 * (s / 3) + (s % 3 + 1) % 3) + 2; };

  std::vector<std::uint32_t> middle(from.opposite.size());
  tbb::parallel_for(std::size_t{0}, edges.size(), [&](std::size_t e) {
    const Side s = edges[e];
    const std::size_t m = old_count + e;
    const std::uint32_t a = from.start(s), b = from.end(s);
    middle[s] = static_cast<std::uint32_t>(m);
    if (from.opposite[s] != kNone) middle[from.opposite[s]] = static_cast<std::uint32_t>(m);
    to.positions[m] = (from.positions[a] + from.positions[b]) / 2;
    result.near[m] = sliding.near[sliding.isOnCurve(a) || sliding.isCorner(a) ? b : a];
    if (from.side_feature[s] != 0) {
      to.feature[m] = 1;
      const std::uint32_t like = sliding.isOnCurve(a) ? a : b;
      result.curve[m] = sliding.curve[like];
      result.segment[m] = sliding.segment[like];
    }
    to.leaving[m] = secondHalf(s);
  });
  tbb::parallel_for(std::size_t{0}, old_count, [&](std::size_t v) {
    if (from.leaving[v] != kNone) to.leaving[v] = firstHalf(from.leaving[v]);
  });
  tbb::parallel_for(std::size_t{0}, triangle_count, [&](std::size_t t) {
    const auto s0 = static_cast<Side>(3 * t);
    const std::uint32_t m[3] = {middle[s0], middle[s0 + 1], middle[s0 + 2]};
    const auto inner = static_cast<Side>(3 * (4 * t + 3));
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t before = (k + 2) % 3, child = static_cast<std::uint32_t>(4 * t) + k;
      to.triangles[child] = {from.triangles[t][k], m[k], m[before]};
      to.materials[child] = from.materials[t];
      // Between the child at corner k and the inner one: m[k] → m[before] and back.
      to.opposite[3 * child + 1] = inner + before;
      to.opposite[inner + before] = 3 * child + 1;
      const Side s = s0 + k, other = from.opposite[s];
      to.side_feature[firstHalf(s)] = to.side_feature[secondHalf(s)] = from.side_feature[s];
      if (other == kNone) continue;
      to.opposite[firstHalf(s)] = secondHalf(other);
      to.opposite[secondHalf(s)] = firstHalf(other);
    }
    to.triangles[4 * t + 3] = {m[0], m[1], m[2]};
    to.materials[4 * t + 3] = from.materials[t];
  });
  return result;
}

}  // namespace bakelight::mesomesh
