#include "transport/glossy.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "transport/gauss_legendre.h"

namespace bakelight::transport {

std::vector<double> phongKernel(int order, double exponent) {
  if (order < 1 || !(exponent >= 0)) throw std::invalid_argument("phongKernel: order or exponent");
  // g_l = (s+1) ∫₀¹ t^s P_l(t) dt; Legendre's recurrence under the integral couples l with l − 2.
  std::vector<double> kernel(order, 1.0);
  if (order > 1) kernel[1] = (exponent + 1) / (exponent + 2);
  for (int l = 2; l < order; ++l) kernel[l] = (exponent - l + 2) / (exponent + l + 1) * kernel[l - 2];
  return kernel;
}

std::vector<double> ggxKernel(int order, double roughness) {
  if (order < 1 || !(roughness >= 0 && roughness <= 1))
    throw std::invalid_argument("ggxKernel: order or roughness");
  const double alpha2 = std::pow(roughness, 4);
  // 1 − g_l is of the order of α² l² log(1/α): here below rounding.
  constexpr double kMirror = 1e-30;
  if (alpha2 < kMirror) return std::vector<double>(order, 1.0);

  // With u = 1 − cos θ, D(θ/2) · cos θ ∝ (1 − u) / (1 + u (1 − α²) / 2α²)²: a peak of width α² at u = 0 with
  // a long tail, so panels that double in width from α² see the same smooth shape each.
  static const std::vector<QuadratureNode> rule = gaussLegendreRule(20);
  std::vector<double> kernel(order, 0.0);
  double norm = 0;
  for (double begin = 0, end = alpha2; begin < 1; begin = end, end = std::min(2 * end, 1.0)) {
    const double half = (end - begin) / 2;
    for (const QuadratureNode& node : rule) {
      const double u = begin + half * (1 + node.x);
      const double fall = 1 + u * (1 - alpha2) / (2 * alpha2);
      const double weight = half * node.weight * (1 - u) / (fall * fall);
      const std::vector<double> p = legendre(order, 1 - u);
      for (int l = 0; l < order; ++l) kernel[l] += weight * p[l];
      norm += weight;
    }
  }
  for (double& factor : kernel) factor /= norm;
  return kernel;
}

void lobeRow(std::span<const double> kernel, const Vec3& local_eye, std::span<double> row) {
  const int order = static_cast<int>(kernel.size());
  if (row.size() < static_cast<std::size_t>(coefficientCount(order)))
    throw std::invalid_argument("lobeRow: the row is shorter than the kernel's bands");
  evaluateSh(order, Vec3(-local_eye.x(), -local_eye.y(), std::abs(local_eye.z())), row);
  for (int l = 0; l < order; ++l)
    for (int m = -l; m <= l; ++m) row[coefficientIndex(l, m)] *= kernel[l];
}

void tableRows(const formats::BrdfTable& table, const Vec3& local_eye, int row_order,
               std::span<double> red_green_blue) {
  const std::size_t count = coefficientCount(row_order), table_count = coefficientCount(table.order);
  if (row_order < 1 || row_order > table.order || table.angles < 1 ||
      table.values.size() != table.angles * 3 * table_count || red_green_blue.size() < 3 * count)
    throw std::invalid_argument("tableRows: table and rows do not fit together");
  const double position = std::clamp(std::abs(local_eye.z()), 0.0, 1.0) * (table.angles - 1);
  const int below = std::min(static_cast<int>(position), std::max(table.angles - 2, 0));
  const int above = std::min(below + 1, table.angles - 1);
  const double share = position - below;

  const double radius = std::hypot(local_eye.x(), local_eye.y());
  const double x = radius > 0 ? local_eye.x() / radius : 1, y = radius > 0 ? local_eye.y() / radius : 0;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const float* low = &table.values[(below * 3 + channel) * table_count];
    const float* high = &table.values[(above * 3 + channel) * table_count];
    double* row = &red_green_blue[channel * count];
    double cosine = 1, sine = 0;  // of m times the azimuth
    for (int m = 0; m < row_order; ++m) {
      for (int l = m; l < row_order; ++l) {
        const int i = coefficientIndex(l, m);
        const double value = (1 - share) * low[i] + share * high[i];
        row[i] = value * cosine;
        if (m > 0) row[coefficientIndex(l, -m)] = value * sine;
      }
      const double next_cosine = x * cosine - y * sine;
      sine = x * sine + y * cosine;
      cosine = next_cosine;
    }
  }
}

}  // namespace bakelight::transport
