#include "transport/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace bakelight::transport {
namespace {

constexpr int kSize = StratifiedBatch::kSize;

TEST(StratifiedBatch, HasAPointInEveryCellAndInEverySixteenth) {
  for (std::uint64_t element = 0; element < 50; ++element)
    for (int dimension = 0; dimension < 20; ++dimension) {
      const StratifiedBatch batch(3, element, 5);
      std::set<std::pair<int, int>> cells;
      std::set<int> columns, rows, intervals;
      for (int s = 0; s < kSize; ++s) {
        const auto [x, y] = batch.pair(s, dimension);
        ASSERT_TRUE(x >= 0 && x < 1 && y >= 0 && y < 1);
        cells.insert({static_cast<int>(4 * x), static_cast<int>(4 * y)});
        columns.insert(static_cast<int>(16 * x));
        rows.insert(static_cast<int>(16 * y));
        const double single = batch.single(s, dimension);
        ASSERT_TRUE(single >= 0 && single < 1);
        intervals.insert(static_cast<int>(16 * single));
      }
      EXPECT_EQ(cells.size(), 16u);
      EXPECT_EQ(columns.size(), 16u);
      EXPECT_EQ(rows.size(), 16u);
      EXPECT_EQ(intervals.size(), 16u);
    }
}

// χ² of counts that should be equal, in standard deviations from its mean.
double deviationOfCounts(const std::vector<int>& counts, int total) {
  const double expected = total / static_cast<double>(counts.size());
  double chi_squared = 0;
  for (const int count : counts) chi_squared += (count - expected) * (count - expected) / expected;
  const auto freedom = static_cast<double>(counts.size() - 1);
  return (chi_squared - freedom) / std::sqrt(2 * freedom);
}

// Whatever the sample, its point is anywhere in the square; and where it is in one dimension says nothing of
// another one, of another sample, of the next batch or of the next element.
TEST(StratifiedBatch, SamplesAreUniformAndDimensionsAndBatchesAreIndependent) {
  constexpr int kBatches = 40000;
  for (const int sample : {0, 5, 15}) {
    std::vector<int> fine(256), dimensions(256), batches(256), elements(256), singles(256);
    for (int i = 0; i < kBatches; ++i) {
      const auto number = static_cast<std::uint64_t>(i);
      const auto sixteenth = [](double x) { return static_cast<std::size_t>(16 * x); };
      const auto cellOf = [](const std::array<double, 2>& point) {
        return 4 * static_cast<std::size_t>(4 * point[1]) + static_cast<std::size_t>(4 * point[0]);
      };
      const StratifiedBatch batch(1, 7, number);
      const auto point = batch.pair(sample, 3);
      ++fine[16 * sixteenth(point[0]) + sixteenth(point[1])];
      ++dimensions[16 * cellOf(point) + cellOf(batch.pair(sample, 4))];
      ++batches[16 * cellOf(point) + cellOf(StratifiedBatch(1, 7, number + 1).pair(sample, 3))];
      ++elements[16 * sixteenth(point[0]) + sixteenth(StratifiedBatch(1, 8, number).pair(sample, 3)[0])];
      ++singles[16 * sixteenth(batch.single(sample, 9)) + sixteenth(point[0])];
    }
    for (const auto* counts : {&fine, &dimensions, &batches, &elements, &singles})
      EXPECT_LT(std::abs(deviationOfCounts(*counts, kBatches)), 4);
  }
}

TEST(StratifiedBatch, DependsOnSeedElementAndBatchAlone) {
  const auto first = StratifiedBatch(1, 2, 3).pair(4, 5);
  EXPECT_EQ(first, StratifiedBatch(1, 2, 3).pair(4, 5));
  EXPECT_NE(first, StratifiedBatch(2, 2, 3).pair(4, 5));
  EXPECT_NE(first, StratifiedBatch(1, 3, 3).pair(4, 5));
  EXPECT_NE(first, StratifiedBatch(1, 2, 4).pair(4, 5));
  EXPECT_NE(StratifiedBatch(1, 2, 3).pair(4, 5), StratifiedBatch(1, 3, 2).pair(4, 5));
}

// Stratified means of smooth functions have a far smaller variance than those of independent samples.
TEST(StratifiedBatch, HelpsSmoothFunctions) {
  double squares = 0;
  constexpr int kBatches = 2000;
  for (int i = 0; i < kBatches; ++i) {
    const StratifiedBatch batch(1, 1, static_cast<std::uint64_t>(i));
    double mean = 0;
    for (int s = 0; s < kSize; ++s) {
      const auto [x, y] = batch.pair(s, 0);
      mean += x * y / kSize;
    }
    squares += (mean - 0.25) * (mean - 0.25) / kBatches;
  }
  const double independent = (1.0 / 9 - 1.0 / 16) / kSize;
  EXPECT_LT(squares, independent / 8);
}

TEST(DrawInterval, DrawsByWeightAndNeverAnEmptyOne) {
  const std::vector<double> weights = {0, 2, 0, 0, 1, 5, 0};
  std::vector<double> cumulative(weights.size() + 1);
  EXPECT_EQ(accumulateProbabilities(weights, cumulative), 8);
  std::vector<double> drawn(weights.size(), 0.0), rest(weights.size(), 0.0);
  constexpr int kCount = 8000;
  for (int i = 0; i < kCount; ++i) {
    const DrawnInterval interval = drawInterval(cumulative, (i + 0.5) / kCount);
    drawn[interval.index] += 8.0 / kCount;
    rest[interval.index] += interval.rest * 8.0 / kCount;
  }
  for (std::size_t i = 0; i < weights.size(); ++i) {
    EXPECT_NEAR(drawn[i], weights[i], 1e-9) << i;
    EXPECT_NEAR(rest[i], weights[i] / 2, 1e-9) << i;  // uniform
  }
  EXPECT_EQ(drawInterval(cumulative, 0).index, 1u);
  EXPECT_EQ(drawInterval(cumulative, 1 - 0x1p-53).index, 5u);
}

}  // namespace
}  // namespace bakelight::transport
