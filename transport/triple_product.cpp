// In the real basis y_lm = T_l|m|(z) · cos mφ (m ≥ 0) or sin |m|φ (m < 0), so Γ is an integral over z times
// one over longitude. The latter has a closed form and leaves |m₃| = |m₁| ± |m₂|; then the integrand over z
// is a polynomial of degree l₁ + l₂ + l₃, which Gauss–Legendre integrates exactly.
#include "transport/triple_product.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "transport/gauss_legendre.h"

namespace bakelight::transport {
namespace {

// ∫ of the three longitude factors over 0 … 2π; `c` is that of the product's side.
double longitudeIntegral(int a, int b, int c) {
  // Sines and cosines multiply to waves of the sum and of the difference, half as high each.
  const int sum = std::abs(a) + std::abs(b), difference = std::abs(std::abs(a) - std::abs(b));
  const bool is_sine = (a < 0) != (b < 0);
  if (is_sine != (c < 0)) return 0;
  double of_sum = 0.5, of_difference = 0.5;  // factors of the two waves
  if (a < 0 && b < 0) of_sum = -0.5;
  if (is_sine) {
    // sin A cos B = (sin(A+B) + sin(A−B)) / 2
    const int sine = std::abs(a < 0 ? a : b), cosine = std::abs(a < 0 ? b : a);
    if (sine < cosine) of_difference = -0.5;
    if (sine == cosine) of_difference = 0;
  }
  double integral = 0;
  const int wave = std::abs(c);
  const double square = wave == 0 ? 2 * std::numbers::pi : std::numbers::pi;
  if (wave == sum) integral += of_sum * square;
  if (wave == difference) integral += of_difference * square;
  return integral;
}

// T_l|m|(z) at the nodes: table[node][l(l+1)+|m|], which is y_l|m| at longitude 0.
std::vector<std::vector<double>> latitudeFactors(int order, std::span<const QuadratureNode> rule) {
  std::vector<std::vector<double>> table;
  for (const QuadratureNode& node : rule)
    table.push_back(evaluateSh(order, Vec3(std::sqrt(1 - node.x * node.x), 0, node.x)));
  return table;
}

void checkOrder(int order) {
  if (order < 1 || order > kMaxOrder)
    throw std::invalid_argument("triple product: order " + std::to_string(order) + " is not in 1.." +
                                std::to_string(kMaxOrder));
}

}  // namespace

TripleProduct::TripleProduct(int row_order, int column_order)
    : row_order_(row_order), column_order_(column_order) {
  checkOrder(row_order);
  checkOrder(column_order);
  // Accidental zeros of the coupling coefficients come out as rounding.
  constexpr double kRounding = 1e-12;
  const std::vector<QuadratureNode> rule = gaussLegendreRule(visibilityOrder());
  const auto latitude = latitudeFactors(visibilityOrder(), rule);

  const auto addEntry = [&](int l1, int m1, int l2, int m2, int l3, int m3) {
    const double longitude = longitudeIntegral(m1, m2, m3);
    if (longitude == 0) return;
    const int i = coefficientIndex(l1, std::abs(m1)), j = coefficientIndex(l2, std::abs(m2));
    const int k = coefficientIndex(l3, std::abs(m3));
    double sum = 0;
    for (std::size_t node = 0; node < rule.size(); ++node)
      sum += rule[node].weight * latitude[node][i] * latitude[node][j] * latitude[node][k];
    const double value = sum * longitude;
    if (std::abs(value) < kRounding) return;
    entries_.push_back({static_cast<std::uint16_t>(coefficientIndex(l1, m1)),
                        static_cast<std::uint16_t>(coefficientIndex(l2, m2)),
                        static_cast<std::uint16_t>(coefficientIndex(l3, m3)), static_cast<float>(value)});
  };
  for (int l1 = 0; l1 < row_order; ++l1)
    for (int m1 = -l1; m1 <= l1; ++m1)
      for (int l2 = 0; l2 < column_order; ++l2)
        for (int m2 = -l2; m2 <= l2; ++m2)
          for (int l3 = std::abs(l1 - l2); l3 <= l1 + l2; l3 += 2)  // other parities are odd functions
            for (int m3 = -l3; m3 <= l3; ++m3) addEntry(l1, m1, l2, m2, l3, m3);
}

void TripleProduct::matrixOf(std::span<const float> visibility, std::span<float> matrix) const {
  const std::size_t columns = coefficientCount(column_order_);
  const std::size_t size = coefficientCount(row_order_) * columns;
  if (visibility.size() < static_cast<std::size_t>(coefficientCount(visibilityOrder())) ||
      matrix.size() < size)
    throw std::invalid_argument("triple product: visibility or matrix is too short");
  auto entry = entries_.begin();
  for (std::size_t cell = 0; cell < size; ++cell) {
    double sum = 0;
    for (; entry != entries_.end() && entry->i * columns + entry->j == cell; ++entry)
      sum += static_cast<double>(entry->value) * visibility[entry->k];
    matrix[cell] = static_cast<float>(sum);
  }
}

void TripleProduct::operatorOf(std::span<const float> light, std::span<float> result) const {
  const std::size_t rows = coefficientCount(row_order_), count = coefficientCount(visibilityOrder());
  if (light.size() < static_cast<std::size_t>(coefficientCount(column_order_)) ||
      result.size() < rows * count)
    throw std::invalid_argument("triple product: light or operator is too short");
  std::vector<double> sums(rows * count, 0.0);
  for (const Entry& entry : entries_)
    sums[entry.i * count + entry.k] += static_cast<double>(entry.value) * light[entry.j];
  for (std::size_t cell = 0; cell < sums.size(); ++cell) result[cell] = static_cast<float>(sums[cell]);
}

}  // namespace bakelight::transport
