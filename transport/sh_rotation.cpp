// Ivanic & Ruedenberg, "Rotation Matrices for Real Spherical Harmonics. Direct Determination by Recursion",
// J. Phys. Chem. 1996, 100, 6342, with the corrections of 1998 (102, 9099). Symbols u, v, w, U, V, W, P are
// the paper's.
#include <array>
#include <cmath>
#include <Eigen/LU>
#include <stdexcept>

#include "transport/sh.h"

namespace bakelight::transport {
namespace {

class BandRecursion {
 public:
  BandRecursion(const Eigen::MatrixXd& first, const Eigen::MatrixXd& below, int l)
      : first_(first), below_(below), l_(l) {}

  Eigen::MatrixXd band() const {
    Eigen::MatrixXd result(2 * l_ + 1, 2 * l_ + 1);
    for (int m = -l_; m <= l_; ++m)
      for (int n = -l_; n <= l_; ++n) result(m + l_, n + l_) = element(m, n);
    return result;
  }

 private:
  double r1(int i, int j) const { return first_(i + 1, j + 1); }
  double rBelow(int a, int b) const { return below_(a + l_ - 1, b + l_ - 1); }

  double p(int i, int a, int b) const {
    if (b == l_) return r1(i, 1) * rBelow(a, l_ - 1) - r1(i, -1) * rBelow(a, -l_ + 1);
    if (b == -l_) return r1(i, 1) * rBelow(a, -l_ + 1) + r1(i, -1) * rBelow(a, l_ - 1);
    return r1(i, 0) * rBelow(a, b);
  }

  double bigV(int m, int n) const {
    if (m == 0) return p(1, 1, n) + p(-1, -1, n);
    if (m == 1) return std::sqrt(2.0) * p(1, 0, n);
    if (m == -1) return std::sqrt(2.0) * p(-1, 0, n);
    return m > 0 ? p(1, m - 1, n) - p(-1, -m + 1, n) : p(1, m + 1, n) + p(-1, -m - 1, n);
  }

  double bigW(int m, int n) const {
    return m > 0 ? p(1, m + 1, n) + p(-1, -m - 1, n) : p(1, m - 1, n) - p(-1, -m + 1, n);
  }

  double element(int m, int n) const {
    const int a = std::abs(m);
    const double denominator =
        std::abs(n) == l_ ? 2.0 * l_ * (2 * l_ - 1) : static_cast<double>((l_ + n) * (l_ - n));
    const double u = std::sqrt((l_ + m) * (l_ - m) / denominator);
    const double v =
        (m == 0 ? -std::sqrt(2.0) : 1.0) * 0.5 * std::sqrt((l_ + a - 1) * (l_ + a) / denominator);
    const double w = m == 0 ? 0 : -0.5 * std::sqrt((l_ - a - 1) * (l_ - a) / denominator);
    // Where a factor is zero, its partner would read outside the band below.
    double sum = v * bigV(m, n);
    if (u != 0) sum += u * p(0, m, n);
    if (w != 0) sum += w * bigW(m, n);
    return sum;
  }

  const Eigen::MatrixXd& first_;
  const Eigen::MatrixXd& below_;
  int l_;
};

}  // namespace

ShRotation::ShRotation(int order, const Eigen::Matrix3d& rotated_from_source) {
  // A mirror image is a point reflection of a rotation, under which band l has the parity of l.
  const double parity = rotated_from_source.determinant() < 0 ? -1 : 1;
  const Eigen::Matrix3d r = parity * rotated_from_source;
  if (order < 1 || order > kMaxEvaluatedOrder) throw std::invalid_argument("SH order out of range");
  const double skew = (r * r.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(skew < 1e-6)) throw std::invalid_argument("not an orthogonal matrix");

  bands_.emplace_back(Eigen::MatrixXd::Identity(1, 1));
  if (order > 1) {
    constexpr std::array<int, 3> kAxis = {1, 2, 0};  // m = −1, 0, 1 are y, z, x
    Eigen::MatrixXd first(3, 3);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) first(i, j) = r(kAxis[i], kAxis[j]);
    bands_.push_back(first);
  }
  for (int l = 2; l < order; ++l) bands_.push_back(BandRecursion(bands_[1], bands_[l - 1], l).band());
  if (parity < 0)
    for (int l = 1; l < order; l += 2) bands_[l] = -bands_[l];
}

void ShRotation::apply(std::span<const double> source, std::span<double> rotated) const {
  for (int l = 0; l < order(); ++l) {
    const Eigen::Map<const Eigen::VectorXd> from(&source[l * l], 2 * l + 1);
    Eigen::Map<Eigen::VectorXd>(&rotated[l * l], 2 * l + 1).noalias() = bands_[l] * from;
  }
}

std::vector<Float3> ShRotation::apply(std::span<const Float3> source) const {
  std::vector<Float3> rotated(coefficientCount(order()));
  std::vector<double> from(rotated.size()), to(rotated.size());
  for (int c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < from.size(); ++i) from[i] = source[i][c];
    apply(std::span<const double>(from), std::span<double>(to));
    for (std::size_t i = 0; i < to.size(); ++i) rotated[i][c] = static_cast<float>(to[i]);
  }
  return rotated;
}

}  // namespace bakelight::transport
