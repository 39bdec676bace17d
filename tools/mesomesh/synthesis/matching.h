// How well a place of an exemplar suits what is around a vertex.
#pragma once

#include <array>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "tools/mesomesh/synthesis/appearance.h"
#include "tools/mesomesh/synthesis/exemplar.h"
#include "tools/mesomesh/synthesis/level_plan.h"

namespace bakelight::mesomesh {

// How an exemplar turns onto itself (FieldFolds): T of a link's turns. T(2) = T(1) T(1), so that ways around a
// vertex agree.
class ExemplarTurns {
 public:
  ExemplarTurns(const Exemplar& exemplar, FieldFolds folds);

  // Within the exemplar where `at` is.
  FixedPoint operator()(FixedPoint at, std::uint32_t turns) const {
    if (turns == 0) return at;
    FixedPoint result = turned(at, turns);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      result[axis] += shifts_[turns][axis];
      if (result[axis] < 0) result[axis] += period_[axis];
      if (result[axis] >= period_[axis]) result[axis] -= period_[axis];
    }
    return result;
  }

 private:
  std::array<FixedPoint, 4> shifts_ = {};  // within [0, period)
  FixedPoint period_ = {0, 0};
};

// What the four sample points look like; those that no vertex predicts count as equal to anything.
struct Surroundings {
  alignas(16) std::array<Appearance, kSamplePoints> appearances = {};
  std::array<bool, kSamplePoints> known = {};
};

class Matcher {
 public:
  Matcher(const AppearanceLevel& appearance, const ExemplarTurns& turns)
      : appearance_(appearance), turns_(turns) {
    for (std::size_t s = 0; s < kSamplePoints; ++s)
      deltas_[s] = appearance.deltaOf(
          {kSampleDirections[s][0] * appearance.step(), kSampleDirections[s][1] * appearance.step()});
  }
  const AppearanceLevel& appearance() const { return appearance_; }
  const ExemplarTurns& turns() const { return turns_; }

  // `coordinates`: of all vertices of the level.
  Surroundings surroundings(const SamplePlan& plan, const FixedPoint* coordinates) const {
    Surroundings result;
    for (std::size_t s = 0; s < kSamplePoints; ++s) {
      const Predictor* predictors = plan.data() + s * kPredictors;
      result.known[s] = predictors[0].weight > 0;
      if (!result.known[s]) continue;
      std::array<std::int32_t, kAppearanceSize> sums;
      sums.fill(kFullWeight / 2);
      for (std::size_t p = 0; p < kPredictors && predictors[p].weight > 0; ++p) {
        FixedPoint at = turns_(coordinates[predictors[p].vertex], predictors[p].turns);
        at[0] += predictors[p].offset[0], at[1] += predictors[p].offset[1];
        const std::int16_t* numbers = appearance_.appearance(at);
        const auto weight = static_cast<std::int16_t>(predictors[p].weight);
        for (std::size_t d = 0; d < kAppearanceSize; ++d) sums[d] += numbers[d] * weight;
      }
      static_assert(kFullWeight == 1 << 8);
      for (std::size_t d = 0; d < kAppearanceSize; ++d)
        result.appearances[s][d] = static_cast<std::int16_t>(sums[d] >> 8);
    }
    return result;
  }

  // Squared difference, at most 4 · 8 · (2 kAppearanceLimit)². `at` within the exemplar.
  std::int32_t error(const Surroundings& surroundings, FixedPoint at) const {
    return error(surroundings, appearance_.appearance(at));
  }
  // This is where synthesis spends its time. Compilers miss that SSE2, which all x86-64 has, can do it.
  std::int32_t error(const Surroundings& surroundings, const std::int16_t* place) const {
#if defined(__SSE2__)
    __m128i sums = _mm_setzero_si128();
    for (std::size_t s = 0; s < kSamplePoints; ++s) {
      if (!surroundings.known[s]) continue;
      const __m128i difference =
          _mm_sub_epi16(_mm_load_si128(reinterpret_cast<const __m128i*>(surroundings.appearances[s].data())),
                        _mm_loadu_si128(reinterpret_cast<const __m128i*>(place + deltas_[s])));
      sums = _mm_add_epi32(sums, _mm_madd_epi16(difference, difference));
    }
    sums = _mm_add_epi32(sums, _mm_shuffle_epi32(sums, _MM_SHUFFLE(1, 0, 3, 2)));
    sums = _mm_add_epi32(sums, _mm_shuffle_epi32(sums, _MM_SHUFFLE(2, 3, 0, 1)));
    return _mm_cvtsi128_si32(sums);
#else
    std::int32_t sum = 0;
    for (std::size_t s = 0; s < kSamplePoints; ++s) {
      if (!surroundings.known[s]) continue;
      const std::int16_t* numbers = place + deltas_[s];
      for (std::size_t d = 0; d < kAppearanceSize; ++d) {
        const int difference = surroundings.appearances[s][d] - numbers[d];
        sum += difference * difference;
      }
    }
    return sum;
#endif
  }

 private:
  const AppearanceLevel& appearance_;
  const ExemplarTurns& turns_;
  std::array<std::ptrdiff_t, kSamplePoints> deltas_;
};

}  // namespace bakelight::mesomesh
