#include "tools/mesomesh/synthesis/correction.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace bakelight::mesomesh {
namespace {

// How much better a similar place must be than what continues a neighbor: coherent patches are what keeps
// features whole (Ashikhmin 2001). In 1/16.
constexpr std::int32_t kCoherencePreference = 2;
// Cells that coordinates then move by themselves: on a curved surface no neighbor continues exactly, and
// what does not add up is spread over a patch instead of breaking it.
constexpr int kRefinements = 2;

class Corrector {
 public:
  Corrector(const LevelPlan& plan, const Matcher& matcher, std::size_t vertex, const FixedPoint* coordinates)
      : plan_(plan),
        matcher_(matcher),
        appearance_(matcher.appearance()),
        vertex_(vertex),
        coordinates_(coordinates),
        surroundings_(matcher.surroundings(plan.samples[vertex], coordinates)) {}

  FixedPoint best() {
    best_ = {coordinates_[vertex_], matcher_.error(surroundings_, coordinates_[vertex_])};
    const std::span<const Proposer> proposers = plan_.proposersOf(vertex_);
    for (const Proposer& proposer : proposers) consider(proposer, coordinates_[proposer.vertex], 0);
    if (best_.error == 0) return best_.at;
    for (const Proposer& proposer : proposers) {
      const FixedPoint at = coordinates_[proposer.vertex];
      const std::array<int, 2> texel = texelOf(at);
      for (const auto& [x, y] : appearance_.similar(texel[0], texel[1]))
        consider(proposer, {at[0] + ((x - texel[0]) << kFixedBits), at[1] + ((y - texel[1]) << kFixedBits)},
                 kCoherencePreference);
    }
    best_.error = matcher_.error(surroundings_, best_.at);
    for (int step = 0; step < kRefinements; ++step) refine();
    return best_.at;
  }

 private:
  // To the best of the four cells next to it, if it is better.
  void refine() {
    const FixedPoint from = best_.at;
    const Fixed cell = appearance_.cellSize();
    for (const FixedPoint& move : {FixedPoint{cell, 0}, {-cell, 0}, {0, cell}, {0, -cell}})
      consider({from[0] + move[0], from[1] + move[1]}, 0);
  }
  std::array<int, 2> texelOf(FixedPoint at) const {
    int x = (at[0] + kHalfTexel) >> kFixedBits, y = (at[1] + kHalfTexel) >> kFixedBits;
    if (x == appearance_.width()) x = 0;
    if (y == appearance_.height()) y = 0;
    return {x, y};
  }
  void consider(const Proposer& proposer, FixedPoint theirs, std::int32_t penalty) {
    const FixedPoint at = matcher_.turns()(theirs, proposer.turns);
    consider({at[0] - proposer.offset[0], at[1] - proposer.offset[1]}, penalty);
  }
  void consider(FixedPoint at, std::int32_t penalty) {
    if (!appearance_.periodic() && !appearance_.contains(at)) return;
    at = appearance_.admitted(at);
    std::int32_t error = matcher_.error(surroundings_, at);
    error += error / 16 * penalty;
    if (error < best_.error) best_ = {at, error};
  }

  const LevelPlan& plan_;
  const Matcher& matcher_;
  const AppearanceLevel& appearance_;
  std::size_t vertex_;
  const FixedPoint* coordinates_;
  Surroundings surroundings_;
  Match best_;
};

}  // namespace

void correctOnce(const LevelState& level, std::size_t ranges, std::vector<FixedPoint>& coordinates) {
  for (std::size_t c = 0; c < level.plan.classCount(); ++c) {
    const std::size_t begin = level.plan.class_first[c], size = level.plan.class_first[c + 1] - begin;
    const std::size_t pieces = std::min(std::max<std::size_t>(ranges, 1), size);
    tbb::parallel_for(std::size_t{0}, pieces, [&](std::size_t piece) {
      for (std::size_t o = begin + size * piece / pieces; o < begin + size * (piece + 1) / pieces; ++o) {
        const std::uint32_t v = level.plan.order[o];
        const Matcher* matcher = level.matchers[level.graph.exemplars[v]];
        if (matcher != nullptr)
          coordinates[v] = Corrector(level.plan, *matcher, v, coordinates.data()).best();
      }
    });
  }
}

}  // namespace bakelight::mesomesh
