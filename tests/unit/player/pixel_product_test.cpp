#include "tools/player/techniques/pixel_product.h"

#include <gtest/gtest.h>

#include <functional>

#include "compression/shared_sums.h"
#include "tools/player/gl/gl_context.h"
#include "transport/sum_product.h"

namespace bakelight::player {
namespace {

using formats::Float3;
using formats::PixelRows;
using transport::Radiance4;

constexpr std::size_t kCells = 16;

// Rows that share stretches of texels, of many lengths; some without an entry.
PixelRows stretches(std::size_t blocks) {
  PixelRows rows;
  rows.cube_side = 8, rows.local_side = 4;
  for (std::size_t row = 0; row < blocks * kCells; ++row) {
    const std::size_t first = row * 5 % 97, length = row % 13 == 0 ? 0 : 3 + row * 7 % 61;
    for (std::size_t k = first; k < first + length; ++k) {
      rows.columns.push_back(static_cast<std::uint16_t>(2 * k));
      rows.codes.push_back(static_cast<std::uint8_t>(k % 5 == 0 ? 1 + row % 4 : 4));
    }
    rows.row_offsets.push_back(rows.columns.size());
  }
  return rows;
}

// Nothing that rows could share.
PixelRows scattered(std::size_t blocks) {
  PixelRows rows;
  rows.cube_side = 32, rows.local_side = 4;
  for (std::size_t row = 0; row < blocks * kCells; ++row) {
    for (std::size_t k = row * row * 31 % 400; k < 6144; k += 90 + (row * 77 + k * k * 13) % 400) {
      rows.columns.push_back(static_cast<std::uint16_t>(k));
      rows.codes.push_back(static_cast<std::uint8_t>(1 + (k * row) % 4));
    }
    rows.row_offsets.push_back(rows.columns.size());
  }
  return rows;
}

struct Case {
  const char* name;
  std::function<PixelRows()> rows;
  std::uint32_t rows_per_tile;
  bool shares;
};
void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

class PixelProducts : public testing::TestWithParam<Case> {
 protected:
  // RGB of each row, as it was before where nothing is written.
  std::vector<Float3> valuesOf(const PixelProduct& product, const PixelRows& rows) {
    std::vector<Float3> light;
    for (const Radiance4& l : lightOf(rows)) light.push_back({l[0] / 4, l[1] / 4, l[2] / 4});
    std::vector<Float3> values(rows.view().rowCount(), Float3{0, 0, 0});
    const Buffer incident = makeBuffer(values.size() * sizeof(Float3), values.data());
    product.run(makeBuffer(light.size() * sizeof(Float3), light.data()), incident);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(incident.name(), 0, static_cast<GLsizeiptr>(values.size() * sizeof(Float3)),
                            values.data());
    throwIfGlFailed("the product");
    return values;
  }
  static std::vector<Radiance4> lightOf(const PixelRows& rows) {
    std::vector<Radiance4> light;
    for (std::size_t k = 0; k < rows.view().columnCount(); ++k)
      light.emplace_back(1 + 0.01F * static_cast<float>(k % 17), k == 20 ? 1e6F : 0.5F, static_cast<float>(k),
                         0);
    return light;
  }
  void expectRows(const PixelProduct& product, const PixelRows& rows) {
    std::vector<Radiance4> expected(rows.view().rowCount());
    transport::multiply(rows.view(), lightOf(rows), expected);
    const std::vector<Float3> values = valuesOf(product, rows);
    for (std::size_t row = 0; row < values.size(); ++row)
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(values[row][c], expected[row][c], 2e-6 * expected[row][c]) << row << " " << c;
  }

  HeadlessContext context_;
};

TEST_P(PixelProducts, AreThoseOfTheRows) {
  const PixelRows rows = GetParam().rows();
  const formats::SumGrammar sums = compression::compress(rows.view(), {GetParam().rows_per_tile, 2});
  ASSERT_EQ(!sums.leaf_columns.empty(), GetParam().shares);
  expectRows(RowProduct(rows.view()), rows);
  expectRows(SumProduct(sums), rows);
}

// Buffers so small that rows, tiles and slices come in many.
TEST_P(PixelProducts, AreTheSameInParts) {
  const PixelRows rows = GetParam().rows();
  const formats::SumGrammar sums = compression::compress(rows.view(), {GetParam().rows_per_tile, 2});
  expectRows(RowProduct(rows.view(), 4096), rows);
  const SumProduct product(sums, 8192);
  EXPECT_GT(product.partCount(), 1U);
  expectRows(product, rows);
  EXPECT_GT(product.gpuBytes(), 4 * sums.terms.size());
}

INSTANTIATE_TEST_SUITE_P(Kinds, PixelProducts,
                         testing::Values(Case{"Sharing", [] { return stretches(120); }, 300, true},
                                         Case{"AsTheyAre", [] { return scattered(12); }, 50, false}),
                         [](const auto& kind) { return kind.param.name; });

TEST(PixelProduct, OfNothingDoesNothing) {
  const HeadlessContext context;
  PixelRows rows;
  rows.local_side = 1;
  rows.row_offsets = {0, 0, 0};
  const SumProduct product(compression::compress(rows.view()));
  const Float3 kept = {1, 2, 3};
  const Buffer light = makeBuffer(6144 * sizeof(Float3), nullptr), incident = makeBuffer(sizeof(kept), &kept);
  product.run(light, incident);
  Float3 read{};
  glGetNamedBufferSubData(incident.name(), 0, sizeof(read), read.data());
  EXPECT_EQ(read, kept);
}

}  // namespace
}  // namespace bakelight::player
