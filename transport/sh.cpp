#include "transport/sh.h"

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace bakelight::transport {
namespace {

constexpr double kPi = std::numbers::pi;

// Factors of the recurrence of the normalised associated Legendre functions divided by sin^m θ, which are
// polynomials in z:
//   Q_l^m = rise[l][m] · (z Q_{l-1}^m − fall[l][m] Q_{l-2}^m),  Q_m^m = start[m].
// Normalised from the start, so nothing overflows and no factorial appears.
struct Recurrence {
  std::array<double, kMaxEvaluatedOrder> start{};
  std::array<std::array<double, kMaxEvaluatedOrder>, kMaxEvaluatedOrder> rise{}, fall{};

  Recurrence() {
    start[0] = std::sqrt(1 / (4 * kPi));
    for (int m = 1; m < kMaxEvaluatedOrder; ++m)
      start[m] = start[m - 1] * std::sqrt((2.0 * m + 1) / (2.0 * m));
    for (int l = 1; l < kMaxEvaluatedOrder; ++l)
      for (int m = 0; m < l; ++m) {
        const double l2 = static_cast<double>(l) * l, m2 = static_cast<double>(m) * m;
        const double below2 = (l - 1.0) * (l - 1.0);
        rise[l][m] = std::sqrt((4 * l2 - 1) / (l2 - m2));
        fall[l][m] = l >= 2 ? std::sqrt((below2 - m2) / (4 * below2 - 1)) : 0;
      }
  }
};

const Recurrence& recurrence() {
  static const Recurrence table;
  return table;
}

void checkOrder(int order, int maximum) {
  if (order < 1 || order > maximum)
    throw std::invalid_argument("SH order " + std::to_string(order) + " is not in 1.." +
                                std::to_string(maximum));
}

}  // namespace

void evaluateSh(int order, const Vec3& direction, std::span<double> values) {
  checkOrder(order, kMaxEvaluatedOrder);
  const Recurrence& table = recurrence();
  const double x = direction.x(), y = direction.y(), z = direction.z();

  // (x + iy)^m = sin^m θ (cos mφ + i sin mφ)
  double cosine = 1, sine = 0;
  for (int m = 0; m < order; ++m) {
    const double scale = m == 0 ? 1 : std::numbers::sqrt2;
    double below = 0, here = table.start[m];
    for (int l = m; l < order; ++l) {
      if (l > m) {
        const double above = table.rise[l][m] * (z * here - table.fall[l][m] * below);
        below = here;
        here = above;
      }
      values[coefficientIndex(l, m)] = scale * here * cosine;
      if (m > 0) values[coefficientIndex(l, -m)] = scale * here * sine;
    }
    const double next_cosine = x * cosine - y * sine;
    sine = x * sine + y * cosine;
    cosine = next_cosine;
  }
}

std::vector<double> evaluateSh(int order, const Vec3& direction) {
  checkOrder(order, kMaxEvaluatedOrder);
  std::vector<double> values(coefficientCount(order));
  evaluateSh(order, direction, values);
  return values;
}

std::vector<double> legendre(int order, double x) {
  std::vector<double> values(order, 1.0);
  if (order > 1) values[1] = x;
  for (int l = 2; l < order; ++l) values[l] = ((2 * l - 1) * x * values[l - 1] - (l - 1) * values[l - 2]) / l;
  return values;
}

std::vector<double> clampedCosineFactors(int order) {
  checkOrder(order, kMaxEvaluatedOrder);
  std::vector<double> factors(order, 0.0);
  factors[0] = kPi;
  if (order > 1) factors[1] = 2 * kPi / 3;
  // Even l: 2π (−1)^{l/2−1} / ((l+2)(l−1)) · l! / (2^l ((l/2)!)²); odd l > 1 vanish.
  double central = 1;  // l! / (2^l ((l/2)!)²)
  for (int l = 2; l < order; l += 2) {
    central *= (l - 1.0) / l;
    factors[l] = (l % 4 == 2 ? 1 : -1) * 2 * kPi / ((l + 2.0) * (l - 1.0)) * central;
  }
  return factors;
}

std::vector<double> diskLightZonal(int order, double half_angle_rad) {
  checkOrder(order, kMaxEvaluatedOrder);
  const double z = std::cos(half_angle_rad);
  const std::vector<double> p = legendre(order + 1, z);
  std::vector<double> zonal(order);
  // 1 − cos a loses all digits of a small disk; 2 sin²(a/2) does not.
  const double half_sine = std::sin(half_angle_rad / 2);
  zonal[0] = std::sqrt(kPi) * 2 * half_sine * half_sine;
  for (int l = 1; l < order; ++l) zonal[l] = std::sqrt(kPi / (2 * l + 1)) * (p[l - 1] - p[l + 1]);
  return zonal;
}

std::vector<double> orientZonal(std::span<const double> zonal, const Vec3& axis) {
  const int order = static_cast<int>(zonal.size());
  std::vector<double> coefficients = evaluateSh(order, axis);
  for (int l = 0; l < order; ++l)
    for (int m = -l; m <= l; ++m)
      coefficients[coefficientIndex(l, m)] *= std::sqrt(4 * kPi / (2 * l + 1)) * zonal[l];
  return coefficients;
}

}  // namespace bakelight::transport
