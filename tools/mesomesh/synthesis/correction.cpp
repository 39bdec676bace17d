#include "tools/mesomesh/synthesis/correction.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace bakelight::mesomesh {
namespace {

// How much better a similar place must be than what continues a neighbor: coherent patches are what keeps
// features whole (Ashikhmin 2001). In 1/16.
constexpr std::int32_t kCoherencePreference = 2;

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
    return best_.at;
  }

 private:
  std::array<int, 2> texelOf(FixedPoint at) const {
    int x = (at[0] + kHalfTexel) >> kFixedBits, y = (at[1] + kHalfTexel) >> kFixedBits;
    if (x == appearance_.width()) x = 0;
    if (y == appearance_.height()) y = 0;
    return {x, y};
  }
  void consider(const Proposer& proposer, FixedPoint theirs, std::int32_t penalty) {
    FixedPoint at = matcher_.turns()(theirs, proposer.turns);
    at[0] -= proposer.offset[0], at[1] -= proposer.offset[1];
    if (appearance_.periodic())
      at = appearance_.admitted(at);
    else if (!appearance_.contains(at))
      return;
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
