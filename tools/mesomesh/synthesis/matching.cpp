#include "tools/mesomesh/synthesis/matching.h"

namespace bakelight::mesomesh {

ExemplarTurns::ExemplarTurns(const Exemplar& exemplar, FieldFolds folds)
    : period_{exemplar.width << kFixedBits, exemplar.height << kFixedBits} {
  const auto within = [&](std::array<int, 2> shift) {
    FixedPoint result;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      result[axis] = (shift[axis] << kFixedBits) % period_[axis];
      if (result[axis] < 0) result[axis] += period_[axis];
    }
    return result;
  };
  if (folds == FieldFolds::kTwo) shifts_[2] = within(exemplar.symmetry.half.shift);
  if (folds != FieldFolds::kFour) return;
  const std::array<int, 2> once = exemplar.symmetry.quarter.shift, again = turned(once, 1);
  shifts_[1] = within(once);
  shifts_[2] = within({once[0] + again[0], once[1] + again[1]});
  const std::array<int, 2> back = turned(once, 3);
  shifts_[3] = within({-back[0], -back[1]});
}

}  // namespace bakelight::mesomesh
