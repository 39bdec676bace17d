#include "tools/mesomesh/synthesis/level_appearance.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "formats/error.h"

namespace bakelight::mesomesh {
namespace {

constexpr double kLeastAcross = 3;  // vertices of a level across an exemplar
constexpr double kLeastStep = 0.25;

int sideOf(const Exemplar& exemplar) {
  return std::min(exemplar.width, exemplar.height);
}

}  // namespace

std::vector<PlacedExemplar> placed(std::span<const Exemplar> exemplars, FieldFolds folds,
                                   double vertex_spacing) {
  std::vector<PlacedExemplar> result;
  for (const Exemplar& exemplar : exemplars) {
    // A mesh without any neighbors has no spacing, and no scale that would matter.
    const double texel_size = exemplar.texel_size.value_or(vertex_spacing > 0 ? vertex_spacing : 1);
    if (folds == FieldFolds::kFour && exemplar.width != exemplar.height)
      throw badInput({exemplar.name, "", ""},
                     "the exemplar has " + std::to_string(exemplar.width) + " × " +
                         std::to_string(exemplar.height) +
                         " texels, and a field of four folds turns it by quarters",
                     "a square exemplar", "crop it, or use a field of one or two folds");
    const double apart = vertex_spacing / texel_size;
    if (apart > std::max(2.0, sideOf(exemplar) / 2.0))
      throw badInput({exemplar.name, "", ""},
                     "neighboring vertices are " + std::to_string(apart) +
                         " of its texels apart, and it has " + std::to_string(sideOf(exemplar)) + " a side",
                     "at most half of the exemplar between two vertices",
                     "ask for more vertices, or for larger texels");
    result.push_back({&exemplar, texel_size, ExemplarTurns(exemplar, folds)});
  }
  return result;
}

bool suits(const PlacedExemplar& placed, double vertex_spacing, bool finest) {
  const double step = vertex_spacing / placed.texel_size;
  return step >= kLeastStep && (finest || step * kLeastAcross <= sideOf(*placed.exemplar));
}

LevelAppearance::LevelAppearance(std::span<const PlacedExemplar> exemplars, double vertex_spacing,
                                 bool finest, int similar)
    : entries_(exemplars.size()), scales_(exemplars.size()), matchers_(exemplars.size()) {
  for (std::size_t e = 0; e < exemplars.size(); ++e) {
    scales_[e].texel_size = exemplars[e].texel_size;
    if (!suits(exemplars[e], vertex_spacing, finest)) continue;
    entries_[e] =
        std::make_unique<Entry>(exemplars[e], vertex_spacing / exemplars[e].texel_size, similar, finest);
    scales_[e].appearance = &entries_[e]->appearance;
    matchers_[e] = &entries_[e]->matcher;
  }
}

double LevelAppearance::leastRetainedVariance() const {
  double least = 1;
  for (const auto& entry : entries_)
    if (entry != nullptr) least = std::min(least, entry->appearance.retainedVariance());
  return least;
}

bool LevelAppearance::empty() const {
  return std::all_of(entries_.begin(), entries_.end(), [](const auto& entry) { return entry == nullptr; });
}

}  // namespace bakelight::mesomesh
