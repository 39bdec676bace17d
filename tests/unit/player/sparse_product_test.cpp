#include "tools/player/operators/sparse_product.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "tools/player/gl/gl_context.h"

namespace bakelight::player {
namespace {

using formats::Float4;

struct Case {
  formats::SparseRows matrix;
  std::vector<Float4> x, y;  // y: what M x is added to
};

// Rows of no entries, of one and of many, so that those that share a row come out even and not.
Case randomCase(std::size_t rows, std::size_t columns, std::size_t most, std::size_t value_columns,
                formats::Precision precision) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::vector<std::uint32_t> ends, places;
  for (std::size_t r = 0; r < rows; ++r) {
    const std::size_t count = r % 7 == 0 ? 0 : random() % (most + 1);
    for (std::size_t e = 0; e < count; ++e) places.push_back(static_cast<std::uint32_t>(random() % columns));
    ends.push_back(static_cast<std::uint32_t>(places.size()));
  }
  std::vector<float> values(places.size() * value_columns);
  for (float& value : values) value = uniform(random);
  Case made{{formats::integersOf(ends), formats::integersOf(places),
             formats::encodeTable(values, value_columns, precision, "made", "values")},
            {},
            {}};
  const auto color = [&] { return Float4{uniform(random), uniform(random), uniform(random), 0}; };
  for (std::size_t c = 0; c < columns; ++c) made.x.push_back(color());
  for (std::size_t r = 0; r < rows; ++r) made.y.push_back(color());
  return made;
}

std::vector<Float4> product(const Case& made, bool adds, std::size_t largest_block_bytes,
                            std::size_t& dispatches) {
  const SparseProduct product(made.matrix, largest_block_bytes);
  const Buffer x = makeBuffer(made.x.size() * sizeof(Float4), made.x.data());
  const Buffer y = makeBuffer(made.y.size() * sizeof(Float4), made.y.data());
  product.multiply(x, y, adds);
  dispatches = product.dispatchCount();
  std::vector<Float4> result(made.y.size());
  glGetNamedBufferSubData(y.name(), 0, static_cast<GLsizeiptr>(result.size() * sizeof(Float4)),
                          result.data());
  return result;
}

void expectProduct(const Case& made, bool adds, const std::vector<Float4>& actual) {
  const std::vector<float> values = made.matrix.values.decode();
  const std::size_t step = made.matrix.values.columns == 3;
  const auto ends = made.matrix.endsOf(), places = made.matrix.columnsOf();
  for (std::size_t r = 0, begin = 0; r < ends.size(); begin = ends[r++])
    for (std::size_t c = 0; c < 3; ++c) {
      double sum = adds ? double{made.y[r][c]} : 0, scale = 1;
      for (std::size_t e = begin; e < ends[r]; ++e) {
        const double term = double{values[e * made.matrix.values.columns + c * step]} * made.x[places[e]][c];
        sum += term, scale += std::abs(term);
      }
      ASSERT_NEAR(actual[r][c], sum, 1e-6 * scale) << "row " << r << ", colour " << c;
    }
}

TEST(SparseProduct, IsTheSumInAnyPrecisionAndInPieces) {
  const HeadlessContext context;
  for (const formats::Precision precision :
       {formats::Precision::kFloat32, formats::Precision::kFloat16, formats::Precision::kUint8})
    for (const std::size_t value_columns : {1U, 3U})
      for (const std::size_t most : {3U, 400U}) {
        SCOPED_TRACE(testing::Message() << nameOf(precision) << " × " << value_columns << ", " << most);
        const Case made = randomCase(300, 120, most, value_columns, precision);
        std::size_t dispatches = 0;
        for (const bool adds : {false, true}) {
          const std::vector<Float4> whole = product(made, adds, 0, dispatches);
          EXPECT_EQ(dispatches, 1U);
          expectProduct(made, adds, whole);
          if (most < 100) continue;
          EXPECT_EQ(product(made, adds, 16384, dispatches), whole);
          EXPECT_GT(dispatches, 3U);
        }
      }
}

TEST(SparseProduct, OfNothingIsNothing) {
  const HeadlessContext context;
  std::size_t dispatches = 0;
  Case made = randomCase(9, 4, 0, 3, formats::Precision::kFloat32);
  EXPECT_EQ(product(made, true, 0, dispatches), made.y);
  EXPECT_EQ(product(made, false, 0, dispatches), std::vector<Float4>(9, Float4{}));
}

}  // namespace
}  // namespace bakelight::player
