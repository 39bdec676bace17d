#include "transport/triple_product.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "tests/unit/transport/quadrature.h"

namespace bakelight::transport {
namespace {

using Orders = std::pair<int, int>;
class TripleProductOrders : public testing::TestWithParam<Orders> {};

// A function of the visibility's order without symmetry; values from a small generator of fixed seed.
std::vector<float> someCoefficients(int count, unsigned seed) {
  std::vector<float> values(count);
  for (float& value : values) {
    seed = seed * 1664525u + 1013904223u;
    value = static_cast<float>(seed >> 8) / static_cast<float>(1 << 23) - 1;
  }
  return values;
}

// M_ij = ∫ V y_i y_j by quadrature that is exact for the degree of the product.
std::vector<double> projectedMatrix(std::span<const float> visibility, int rows, int columns) {
  const int visibility_order = rows + columns - 1;
  std::vector<double> matrix(coefficientCount(rows) * coefficientCount(columns), 0.0);
  for (const auto& [direction, weight] : sphereQuadrature(2 * (visibility_order - 1))) {
    const std::vector<double> y = evaluateSh(visibility_order, direction);
    double value = 0;
    for (std::size_t k = 0; k < visibility.size(); ++k) value += visibility[k] * y[k];
    for (int i = 0; i < coefficientCount(rows); ++i)
      for (int j = 0; j < coefficientCount(columns); ++j)
        matrix[i * coefficientCount(columns) + j] += weight * value * y[i] * y[j];
  }
  return matrix;
}

TEST_P(TripleProductOrders, MatrixEqualsProjectionOfTheProduct) {
  const auto [rows, columns] = GetParam();
  const TripleProduct product(rows, columns);
  ASSERT_EQ(product.visibilityOrder(), rows + columns - 1);
  const std::vector<float> visibility = someCoefficients(coefficientCount(product.visibilityOrder()), 7);
  const std::vector<double> expected = projectedMatrix(visibility, rows, columns);
  std::vector<float> matrix(expected.size());
  product.matrixOf(visibility, matrix);
  const double largest =
      std::abs(*std::ranges::max_element(expected, {}, [](double x) { return std::abs(x); }));
  for (std::size_t cell = 0; cell < expected.size(); ++cell)
    ASSERT_NEAR(matrix[cell], expected[cell], 2e-6 * largest) << "cell " << cell;
}

TEST_P(TripleProductOrders, OperatorAppliesTheMatrixToALight) {
  const auto [rows, columns] = GetParam();
  const TripleProduct product(rows, columns);
  const int row_count = coefficientCount(rows), column_count = coefficientCount(columns);
  const int visibility_count = coefficientCount(product.visibilityOrder());
  const std::vector<float> visibility = someCoefficients(visibility_count, 3);
  const std::vector<float> light = someCoefficients(column_count, 4);
  std::vector<float> matrix(row_count * column_count), operator_of_light(row_count * visibility_count);
  product.matrixOf(visibility, matrix);
  product.operatorOf(light, operator_of_light);
  for (int i = 0; i < row_count; ++i) {
    double by_matrix = 0, by_operator = 0;
    for (int j = 0; j < column_count; ++j) by_matrix += double{matrix[i * column_count + j]} * light[j];
    for (int k = 0; k < visibility_count; ++k)
      by_operator += double{operator_of_light[i * visibility_count + k]} * visibility[k];
    ASSERT_NEAR(by_matrix, by_operator, 1e-5 * visibility_count) << "row " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Orders, TripleProductOrders,
                         testing::Values(Orders{1, 1}, Orders{2, 2}, Orders{3, 3}, Orders{4, 4}, Orders{5, 5},
                                         Orders{6, 6}, Orders{7, 7}, Orders{8, 8}, Orders{9, 9},
                                         Orders{10, 10}, Orders{5, 3}, Orders{3, 5}, Orders{1, 10},
                                         Orders{10, 4}),
                         [](const auto& instance) {
                           return "Rows" + std::to_string(instance.param.first) + "Columns" +
                                  std::to_string(instance.param.second);
                         });

TEST(TripleProduct, IsSymmetricInItsThreeIndices) {
  const TripleProduct product(5, 5);
  std::map<std::array<int, 3>, float> tensor;
  for (const auto& entry : product.entries()) tensor[{entry.i, entry.j, entry.k}] = entry.value;
  for (const auto& [index, value] : tensor) {
    const auto [i, j, k] = index;
    ASSERT_NEAR((tensor[{j, i, k}]), value, 1e-7);
    if (k < coefficientCount(5)) {
      ASSERT_NEAR((tensor[{i, k, j}]), value, 1e-7);
    }
  }
}

TEST(TripleProduct, ProductWithTheConstantIsTheIdentity) {
  const TripleProduct product(4, 6);
  const double constant = std::sqrt(1 / (4 * std::numbers::pi));
  int seen = 0;
  for (const auto& [i, j, k, value] : product.entries())
    if (k == 0) {
      EXPECT_EQ(i, j);
      EXPECT_NEAR(value, constant, 1e-7);
      ++seen;
    }
  EXPECT_EQ(seen, coefficientCount(4));
}

// Bands that couple obey the triangle rule and have an even sum; the entries are exactly those of the dense
// tensor that differ from zero, in order.
TEST(TripleProduct, HoldsExactlyTheEntriesThatDifferFromZero) {
  const int rows = 4, columns = 3, visibility_order = rows + columns - 1;
  std::vector<double> dense(coefficientCount(rows) * coefficientCount(columns) *
                            coefficientCount(visibility_order));
  for (const auto& [direction, weight] : sphereQuadrature(2 * (visibility_order - 1))) {
    const std::vector<double> y = evaluateSh(visibility_order, direction);
    std::size_t cell = 0;
    for (int i = 0; i < coefficientCount(rows); ++i)
      for (int j = 0; j < coefficientCount(columns); ++j)
        for (int k = 0; k < coefficientCount(visibility_order); ++k)
          dense[cell++] += weight * y[i] * y[j] * y[k];
  }
  const TripleProduct product(rows, columns);
  std::size_t cell = 0, entry = 0;
  const auto band = [](int index) { return static_cast<int>(std::sqrt(index + 0.5)); };
  for (int i = 0; i < coefficientCount(rows); ++i)
    for (int j = 0; j < coefficientCount(columns); ++j)
      for (int k = 0; k < coefficientCount(visibility_order); ++k, ++cell) {
        if (std::abs(dense[cell]) < 1e-12) continue;
        EXPECT_GE(band(k), std::abs(band(i) - band(j)));
        EXPECT_LE(band(k), band(i) + band(j));
        EXPECT_EQ((band(i) + band(j) + band(k)) % 2, 0);
        ASSERT_LT(entry, product.entries().size());
        const TripleProduct::Entry& found = product.entries()[entry++];
        ASSERT_EQ(std::tuple(int{found.i}, int{found.j}, int{found.k}), std::tuple(i, j, k));
        ASSERT_NEAR(found.value, dense[cell], 1e-7);
      }
  EXPECT_EQ(entry, product.entries().size());
}

TEST(TripleProduct, RefusesOrdersAndSizesOutOfRange) {
  EXPECT_THROW(TripleProduct(0, 5), std::invalid_argument);
  EXPECT_THROW(TripleProduct(5, 11), std::invalid_argument);
  const TripleProduct product(2, 2);
  std::vector<float> short_visibility(8), matrix(16);
  EXPECT_THROW(product.matrixOf(short_visibility, matrix), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::transport
