#include "tools/bicluster/greedy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/pixel_rows.h"
#include "transport/sum_product.h"

namespace bakelight::bicluster {
namespace {

using namespace tests;
using transport::Radiance4;

TEST(Greedy, TakesTheWholeMatrixApart) {
  for (const PixelRows& rows : {ballRows(12, 12, 4, 2), noiseRows(200, 20, 8, 3), ballRows(1, 16, 8, 2)}) {
    const Biclusters biclusters = greedyBiclusters(rows.view(), 3);
    EXPECT_TRUE(sameRows(decode(biclusters), rows));
    EXPECT_LE(biclusters.operations(), 2 * rows.columns.size());
  }
}

// The paper's example (IV.C): 3 × 4 elements, twelve of which eleven are not zero; one bicluster of 3 rows and 4 columns costs 10, and
// 2 elements of the residual 4.
TEST(Greedy, FindsThePapersBicluster) {
  PixelRows rows = emptyRows(1, 1, 2);
  rows.columns = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2};
  rows.codes = {4, 2, 3, 4, 4, 3, 3, 4, 4, 2, 3};
  rows.row_offsets = {0, 4, 8, 11};
  // Where it starts decides what it finds.
  std::uint64_t fewest = 100;
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    const Biclusters biclusters = greedyBiclusters(rows.view(), seed);
    EXPECT_TRUE(sameRows(decode(biclusters), rows));
    EXPECT_LT(biclusters.operations(), 2 * rows.columns.size());
    fewest = std::min(fewest, biclusters.operations());
  }
  EXPECT_LE(fewest, 14U);
}

TEST(Greedy, MultipliesAsTheMatrixDoes) {
  const PixelRows rows = ballRows(10, 12, 4, 2);
  std::vector<Radiance4> light(rows.view().columnCount(), Radiance4(1, 2, 3, 0));
  std::vector<Radiance4> expected(rows.view().rowCount()), values(rows.view().rowCount());
  transport::multiply(rows.view(), light, expected);
  multiply(greedyBiclusters(rows.view()), light, values);
  for (std::size_t row = 0; row < values.size(); ++row) EXPECT_NEAR(values[row][1], expected[row][1], 1e-4);
}

}  // namespace
}  // namespace bakelight::bicluster
