#include <algorithm>
#include <numeric>
#include <queue>

#include "tools/mesomesh/synthesis/correction.h"

namespace bakelight::mesomesh {
namespace {

// How far along the field's first axis each vertex lies, from the first vertex of its component.
std::vector<float> sweepDistances(const SurfaceGraph& graph) {
  std::vector<float> distances(graph.vertexCount());
  std::vector<std::uint8_t> reached(graph.vertexCount());
  for (std::uint32_t root = 0; root < graph.vertexCount(); ++root) {
    if (reached[root] != 0) continue;
    reached[root] = 1;
    std::queue<std::uint32_t> front({root});
    for (; !front.empty(); front.pop())
      for (const Link& link : graph.linksOf(front.front())) {
        if (reached[link.to] != 0) continue;
        reached[link.to] = 1;
        distances[link.to] = distances[front.front()] + link.offset[0];
        front.push(link.to);
      }
  }
  return distances;
}

}  // namespace

Match bestOfAll(const Matcher& matcher, const Surroundings& surroundings, const Match& start) {
  const AppearanceLevel& appearance = matcher.appearance();
  const Fixed cell = appearance.cellSize();
  FixedPoint begin = {0, 0}, end = {appearance.width() << kFixedBits, appearance.height() << kFixedBits};
  if (!appearance.periodic()) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      begin[axis] = (appearance.least()[axis] + cell - 1) / cell * cell;
      end[axis] = appearance.greatest()[axis] + 1;
    }
  }
  Match best = start;
  if (best.error == 0) return best;
  FixedPoint at;
  for (at[1] = begin[1]; at[1] < end[1]; at[1] += cell) {
    at[0] = begin[0];
    const std::int16_t* place = appearance.appearance(at);
    for (; at[0] < end[0]; at[0] += cell, place += kAppearanceSize) {
      const std::int32_t error = matcher.error(surroundings, place);
      if (error < best.error) best = {at, error};
    }
  }
  return best;
}

std::size_t searchOnce(const LevelState& level, std::vector<FixedPoint>& coordinates) {
  std::size_t changed = 0;
  const std::vector<float> distances = sweepDistances(level.graph);
  std::vector<std::uint32_t> order(distances.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return distances[a] < distances[b]; });
  for (const std::uint32_t v : order) {
    const Matcher* matcher = level.matchers[level.graph.exemplars[v]];
    if (matcher == nullptr) continue;
    const Surroundings surroundings = matcher->surroundings(level.plan.samples[v], coordinates.data());
    const Match own{coordinates[v], matcher->error(surroundings, coordinates[v])};
    const Match best = bestOfAll(*matcher, surroundings, own);
    if (best.error == own.error) continue;
    coordinates[v] = best.at;
    ++changed;
  }
  return changed;
}

}  // namespace bakelight::mesomesh
