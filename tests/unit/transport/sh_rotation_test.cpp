#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numbers>

#include "tests/unit/transport/quadrature.h"
#include "transport/sh.h"

namespace bakelight::transport {
namespace {

Eigen::Matrix3d rotation(double angle, const Vec3& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

std::vector<Eigen::Matrix3d> someRotations() {
  return {Eigen::Matrix3d::Identity(),
          rotation(0.7, Vec3(0, 1, 0)),
          rotation(std::numbers::pi, Vec3(1, 0, 0)),
          rotation(std::numbers::pi / 2, Vec3(0, 0, 1)),
          rotation(2.1, Vec3(1, -2, 3)),
          rotation(1e-7, Vec3(3, 1, 1))};
}

TEST(ShRotation, EqualsProjectingTheRotatedFunction) {
  const int order = kMaxOrder, count = coefficientCount(order);
  std::vector<double> source(count);
  for (int i = 0; i < count; ++i) source[i] = std::sin(1.3 * i + 0.4);
  for (const Eigen::Matrix3d& r : someRotations()) {
    std::vector<double> rotated(count), projected(count, 0.0);
    ShRotation(order, r).apply(std::span<const double>(source), std::span<double>(rotated));
    for (const auto& [direction, weight] : sphereQuadrature(2 * (order - 1))) {
      const std::vector<double> before = evaluateSh(order, r.transpose() * direction);
      double value = 0;
      for (int i = 0; i < count; ++i) value += source[i] * before[i];
      const std::vector<double> basis = evaluateSh(order, direction);
      for (int i = 0; i < count; ++i) projected[i] += weight * value * basis[i];
    }
    for (int i = 0; i < count; ++i) EXPECT_NEAR(rotated[i], projected[i], 1e-11) << "coefficient " << i;
  }
}

TEST(ShRotation, ComposesLikeRotations) {
  for (const Eigen::Matrix3d& a : someRotations())
    for (const Eigen::Matrix3d& b : someRotations()) {
      const ShRotation ra(kMaxEvaluatedOrder, a), rb(kMaxEvaluatedOrder, b), rab(kMaxEvaluatedOrder, a * b);
      for (int l = 0; l < kMaxEvaluatedOrder; ++l)
        EXPECT_LT((ra.band(l) * rb.band(l) - rab.band(l)).cwiseAbs().maxCoeff(), 1e-11) << "band " << l;
    }
}

TEST(ShRotation, IsOrthogonal) {
  for (const Eigen::Matrix3d& r : someRotations()) {
    const ShRotation rotation(kMaxEvaluatedOrder, r);
    for (int l = 0; l < kMaxEvaluatedOrder; ++l) {
      const Eigen::MatrixXd& band = rotation.band(l);
      const auto identity = Eigen::MatrixXd::Identity(2 * l + 1, 2 * l + 1);
      EXPECT_LT((band * band.transpose() - identity).cwiseAbs().maxCoeff(), 1e-11) << "band " << l;
    }
  }
}

// A mirror image of the function, too.
TEST(ShRotation, MirrorsWhatMirrors) {
  Eigen::Matrix3d mirror = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  mirror.row(1) = -mirror.row(1);
  const Vec3 direction = Vec3(0.3, -0.5, 0.8).normalized();
  std::vector<double> source(49), mirrored(49), expected(49);
  evaluateSh(7, direction, source);
  evaluateSh(7, mirror * direction, expected);
  ShRotation(7, mirror).apply(source, mirrored);
  for (std::size_t i = 0; i < source.size(); ++i) EXPECT_NEAR(mirrored[i], expected[i], 1e-12);
}

TEST(ShRotation, RefusesWhatIsNoRotation) {
  EXPECT_THROW(ShRotation(3, 2 * Eigen::Matrix3d::Identity()), std::invalid_argument);
  Eigen::Matrix3d broken = Eigen::Matrix3d::Identity();
  broken(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(ShRotation(3, broken), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::transport
