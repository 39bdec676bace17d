// Coordinates of a level's vertices, improved until they suit each other.
#pragma once

#include <span>
#include <vector>

#include "tools/mesomesh/synthesis/level_plan.h"
#include "tools/mesomesh/synthesis/matching.h"

namespace bakelight::mesomesh {

// One level as its corrections need it.
struct LevelState {
  const SurfaceGraph& graph;
  const LevelPlan& plan;
  std::span<const Matcher* const> matchers;  // of each exemplar; none where the level does not suit it
};

// One pass of k-coherence (Tong et al. 2002) in sub-passes (Lefebvre & Hoppe 2006): each vertex takes the best
// of its own coordinates, what its neighbors propose, and the places similar to those. A class after the
// other; the vertices of one in `ranges` pieces side by side, which changes nothing in the outcome.
void correctOnce(const LevelState& level, std::size_t ranges, std::vector<FixedPoint>& coordinates);

// One sweep of exhaustive search: vertices in the order of Turk 2001 (along the field's first axis), each the
// best of all places of the exemplar, to a cell of its table. Returns how many vertices
// changed. Hours for a large mesh: it is the measure of the other.
std::size_t searchOnce(const LevelState& level, std::vector<FixedPoint>& coordinates);

struct Match {
  FixedPoint at = {0, 0};
  std::int32_t error = 0;
};
// The best of all cells; the first of equals. `start`: an error that is known to be reached.
Match bestOfAll(const Matcher& matcher, const Surroundings& surroundings, const Match& start);

}  // namespace bakelight::mesomesh
