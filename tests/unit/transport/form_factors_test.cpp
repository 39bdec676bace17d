#include "transport/form_factors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>

namespace bakelight::transport {
namespace {

using testing::ElementsAre;
using Row = std::vector<SeenVertex>;

class Random {
 public:
  explicit Random(unsigned seed) : generator_(seed) {}
  double uniform() { return std::uniform_real_distribution<double>(0, 1)(generator_); }

 private:
  std::mt19937 generator_;
};

double sumOf(const Row& row) {
  return std::accumulate(row.begin(), row.end(), 0.0,
                         [](double sum, const SeenVertex& seen) { return sum + seen.weight; });
}

// Weights over three orders of magnitude, a few sides apart.
Row spreadRow(unsigned seed, std::size_t count) {
  Random random(seed);
  Row row;
  for (std::size_t i = 0; i < count; ++i)
    row.push_back({static_cast<std::uint32_t>(7 * i + seed),
                   static_cast<float>(1e-5 * std::pow(1e3, random.uniform()))});
  return row;
}

TEST(SeenSums, AddUpBySideHoweverTheHashesFall) {
  SeenSums sums(300);
  Random random(1);
  for (int round = 0; round < 3; ++round) {
    std::map<std::uint32_t, float> expected;
    for (int i = 0; i < 2000; ++i) {
      const auto side = static_cast<std::uint32_t>(random.uniform() * 290) * 4096;  // many collide
      const auto weight = static_cast<float>(random.uniform());
      expected[side] += weight;
      sums.add(side, weight);
    }
    Row row;
    for (const auto& [side, weight] : expected) row.push_back({side, weight});
    EXPECT_EQ(sums.take(), row);
    EXPECT_TRUE(sums.take().empty());
  }
}

TEST(PutSmallTogether, KeepsSumOrderAndLargeShares) {
  for (const float threshold : {1e-5F, 1e-4F, 1e-3F, 3e-3F, 1.0F}) {
    const Row row = spreadRow(3, 500);
    Row put = row;
    putSmallTogether(put, threshold);
    EXPECT_EQ(put.size(), countPutTogether(row, threshold)) << threshold;
    EXPECT_NEAR(sumOf(put), sumOf(row), 1e-6 * sumOf(row)) << threshold;
    for (std::size_t i = 1; i < put.size(); ++i) EXPECT_LT(put[i - 1].side, put[i].side);
    for (const SeenVertex& seen : row) {
      const bool kept = seen.weight >= threshold;
      EXPECT_TRUE(!kept || std::find(put.begin(), put.end(), seen) != put.end());
    }
  }
  Row all = spreadRow(3, 500);
  putSmallTogether(all, 1);
  EXPECT_EQ(all.size(), 1U);
}

TEST(PutSmallTogether, LeavesWhatHasNothingSmall) {
  const Row large = {{2, 0.25F}, {5, 0.5F}}, one = {{2, 1e-6F}, {5, 0.5F}};
  for (const Row& row : {large, one, Row{}}) {
    Row put = row;
    putSmallTogether(put, 0.1F);
    EXPECT_EQ(put, row);
  }
}

// What a side gets over many rows is what it had: nothing is favoured.
TEST(PutSmallTogether, IsWithoutBias) {
  std::map<std::uint32_t, double> before, after;
  constexpr int kRows = 40000;
  Random random(5);
  for (int i = 0; i < kRows; ++i) {
    Row row;
    for (std::uint32_t side = 0; side < 20; ++side)
      row.push_back({side, static_cast<float>(1e-3 * (1 + side) * random.uniform())});
    for (const SeenVertex& seen : row) before[seen.side] += seen.weight;
    putSmallTogether(row, 0.04F);
    for (const SeenVertex& seen : row) after[seen.side] += seen.weight;
  }
  for (const auto& [side, weight] : before) EXPECT_NEAR(after[side] / weight, 1, 0.1) << side;
}

FormFactors factorsOf(const ShareStorage& storage, const std::vector<Row>& rows) {
  FormFactors factors(storage);
  factors.append(factors.packed(std::span(rows).first(2)));
  factors.append(factors.packed({}));
  factors.append(factors.packed(std::span(rows).subspan(2)));
  return factors;
}

TEST(FormFactors, ExactRowsComeBackAsTheyWere) {
  const std::vector<Row> rows = {spreadRow(1, 5), {}, spreadRow(2, 9), spreadRow(3, 1)};
  FormFactors factors = factorsOf({}, rows);
  ASSERT_EQ(factors.rowCount(), rows.size());
  EXPECT_EQ(factors.shareCount(), 15U);
  for (std::size_t r = 0; r < rows.size(); ++r) EXPECT_EQ(factors.row(r), rows[r]) << r;
  for (const Row& row : {spreadRow(4, 12), Row{}, spreadRow(5, 2)}) {
    factors.replace(2, row);
    EXPECT_EQ(factors.row(1), rows[1]);
    EXPECT_EQ(factors.row(2), row);
    EXPECT_EQ(factors.row(3), rows[3]);
  }
}

TEST(FormFactors, SixteenBitsKeepTheSum) {
  const std::vector<Row> rows = {spreadRow(1, 500), {}, spreadRow(2, 900), {{3, 1e-30F}}};
  FormFactors factors = factorsOf({false, 0}, rows);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Row held = factors.row(r);
    ASSERT_EQ(held.size(), rows[r].size());
    EXPECT_NEAR(sumOf(held), sumOf(rows[r]), 1e-6 * sumOf(rows[r]));
    for (std::size_t k = 0; k < held.size(); ++k) {
      EXPECT_EQ(held[k].side, rows[r][k].side);
      EXPECT_NEAR(held[k].weight, rows[r][k].weight, 1e-2 / 65535);
    }
  }
  factors.replace(0, rows[2]);
  EXPECT_EQ(factors.row(0), factors.row(2));
  EXPECT_EQ(factors.row(3).size(), 1U);
  EXPECT_LT(factors.bytes(), 6 * factors.shareCount() + 1000);
}

TEST(FormFactors, RenumberedByItsTable) {
  FormFactors factors = factorsOf({}, {{{1, 0.5F}}, {{0, 0.5F}}, {{2, 1}}});
  factors.renumber(std::vector<std::uint32_t>{10, 11, 12});
  EXPECT_THAT(factors.row(0), ElementsAre(SeenVertex{11, 0.5F}));
  EXPECT_THAT(factors.row(2), ElementsAre(SeenVertex{12, 1}));
}

}  // namespace
}  // namespace bakelight::transport
