// Real spherical harmonics: evaluation, zonal closed forms, rotation.
//
// Conventions (docs/NUMERICS.md): index i = l(l+1)+m; the signs of the Cartesian table of Fujita & Kanai 2004
// (no Condon–Shortley phase): y(1,-1) = √(3/4π)·y, y(1,0) = √(3/4π)·z, y(1,1) = √(3/4π)·x. "Order n" means n
// bands, n² coefficients.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "transport/vector_types.h"

namespace bakelight::transport {

inline constexpr int kMaxOrder = 10;  // of transfer and light
inline constexpr int kMaxEvaluatedOrder =
    2 * kMaxOrder - 1;  // a product of two order-n functions has order 2n-1

constexpr int coefficientCount(int order) {
  return order * order;
}
constexpr int coefficientIndex(int l, int m) {
  return l * (l + 1) + m;
}

// All y_lm(direction) below `order` (1–19); `direction` is unit; `values` has order² elements. No
// trigonometry: the recurrences run in Cartesian form and are stable at the poles. Cost: about 2
// multiply-adds a coefficient.
void evaluateSh(int order, const Vec3& direction, std::span<double> values);
std::vector<double> evaluateSh(int order, const Vec3& direction);

// Legendre polynomials P_0 … P_{order-1} at x in [-1, 1].
std::vector<double> legendre(int order, double x);

// Zonal factors A_l of the clamped cosine max(n·s, 0): its projection is A_l · y_lm(n). π, 2π/3, π/4, 0,
// −π/24, … (Ramamoorthi & Hanrahan 2001).
std::vector<double> clampedCosineFactors(int order);

// Unit-radiance disk light of half angle `half_angle_rad` (0–π) around +z: L_l = √(π/(2l+1)) (P_{l−1}(cos a)
// − P_{l+1}(cos a)).
std::vector<double> diskLightZonal(int order, double half_angle_rad);

// Turns zonal coefficients z_l (about +z) towards `axis` (unit): c_lm = √(4π/(2l+1)) z_l y_lm(axis). order²
// values.
std::vector<double> orientZonal(std::span<const double> zonal, const Vec3& axis);

// Rotation (or mirror image) of SH coefficients: if f' (s) = f(Rᵀ s), that is, the function carried along by R, then
// coefficients(f') = ShRotation(order, R).apply(coefficients(f)). Ivanic & Ruedenberg 1996 (with the 1998
// corrections).
class ShRotation {
 public:
  // `rotated_from_source` is orthogonal (to 1e-6, else std::invalid_argument). order
  // 1–19.
  ShRotation(int order, const Eigen::Matrix3d& rotated_from_source);

  int order() const { return static_cast<int>(bands_.size()); }
  // (2l+1)×(2l+1), rows and columns by m = −l … l.
  const Eigen::MatrixXd& band(int l) const { return bands_[l]; }
  void apply(std::span<const double> source, std::span<double> rotated) const;
  // Per colour channel.
  std::vector<Float3> apply(std::span<const Float3> source) const;

 private:
  std::vector<Eigen::MatrixXd> bands_;
};

}  // namespace bakelight::transport
