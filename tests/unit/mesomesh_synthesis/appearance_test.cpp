#include "tools/mesomesh/synthesis/appearance.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/exemplars.h"

namespace bakelight::mesomesh {
namespace {

int squaredDistance(const std::int16_t* a, const std::int16_t* b) {
  int sum = 0;
  for (int d = 0; d < kAppearanceSize; ++d) sum += (a[d] - b[d]) * (a[d] - b[d]);
  return sum;
}

FixedPoint texel(int x, int y) {
  return {x << kFixedBits, y << kFixedBits};
}

TEST(Appearance, RepeatsWithThePeriod) {
  const AppearanceLevel level(makeExemplar(tests::stones(32, 8), {}, ""), 1, 0);
  for (const int x : {-2, 0, 1})
    EXPECT_EQ(squaredDistance(level.appearance(texel(x, 5)), level.appearance(texel(x + 32, 5))), 0);
  EXPECT_GT(squaredDistance(level.appearance(texel(3, 5)), level.appearance(texel(9, 5))), 0);
  EXPECT_EQ(level.appearance(texel(3, 5)) + level.deltaOf(texel(1, -2)), level.appearance(texel(4, 3)));
}

// The same place of each of the sixteen repeats of a checkered exemplar.
TEST(Appearance, OfEqualSurroundingsIsEqual) {
  const AppearanceLevel level(makeExemplar(tests::checks(32, 4), {}, ""), 2, 0);
  EXPECT_GT(level.retainedVariance(), 0.999);
  EXPECT_LE(squaredDistance(level.appearance(texel(3, 5)), level.appearance(texel(11, 29))), kAppearanceSize);
}

TEST(Appearance, FindsTheMostSimilarTexels) {
  for (const bool periodic : {true, false}) {
    const AppearanceLevel level(makeExemplar(tests::stones(24, 5), {periodic, {}}, ""), 1, 2);
    for (const auto& [x, y] : {std::array{4, 4}, {12, 7}, {19, 19}}) {
      // By trying all: at least 3 texels away, and from the first.
      const auto apart = [&](int a, int b) {
        const int d = std::abs(a - b);
        return periodic ? std::min(d, 24 - d) : d;
      };
      std::array<int, 2> first = {x, y};
      for (std::size_t k = 0; k < 2; ++k) {
        int best = std::numeric_limits<int>::max();
        for (int row = 0; row < 24; ++row)
          for (int column = 0; column < 24; ++column) {
            const auto tooClose = [&](int from_x, int from_y) {
              return apart(column, from_x) * apart(column, from_x) + apart(row, from_y) * apart(row, from_y) <
                     9;
            };
            if (tooClose(x, y) || (k == 1 && tooClose(first[0], first[1])) ||
                !level.contains(texel(column, row)))
              continue;
            best = std::min(
                best, squaredDistance(level.appearance(texel(x, y)), level.appearance(texel(column, row))));
          }
        const auto [column, row] = level.similar(x, y)[k];
        EXPECT_EQ(squaredDistance(level.appearance(texel(x, y)), level.appearance(texel(column, row))), best);
        first = {column, row};
      }
    }
  }
}

}  // namespace
}  // namespace bakelight::mesomesh
