#include "transport/sh.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numbers>

#include "tests/unit/transport/quadrature.h"

namespace bakelight::transport {
namespace {

constexpr double kPi = std::numbers::pi;

const std::vector<Vec3>& someDirections() {
  static const std::vector<Vec3> directions = {Vec3(0, 0, 1),
                                               Vec3(0, 0, -1),
                                               Vec3(1, 0, 0),
                                               Vec3(0, -1, 0),
                                               Vec3(1, 2, 3).normalized(),
                                               Vec3(-0.3, 0.2, -0.9).normalized(),
                                               Vec3(1e-9, 1e-9, 1).normalized(),
                                               Vec3(-5, 1, 0.01).normalized()};
  return directions;
}

// Fujita & Kanai 2004, Table 3.
TEST(Sh, MatchesTheCartesianTable) {
  for (const Vec3& d : someDirections()) {
    const double x = d.x(), y = d.y(), z = d.z();
    const std::vector<double> expected = {std::sqrt(1 / (4 * kPi)),
                                          std::sqrt(3 / (4 * kPi)) * y,
                                          std::sqrt(3 / (4 * kPi)) * z,
                                          std::sqrt(3 / (4 * kPi)) * x,
                                          std::sqrt(15 / (4 * kPi)) * x * y,
                                          std::sqrt(15 / (4 * kPi)) * y * z,
                                          std::sqrt(5 / (16 * kPi)) * (3 * z * z - 1),
                                          std::sqrt(15 / (4 * kPi)) * x * z,
                                          std::sqrt(15 / (16 * kPi)) * (x * x - y * y),
                                          std::sqrt(35 / (32 * kPi)) * y * (3 * x * x - y * y),
                                          std::sqrt(105 / (4 * kPi)) * x * y * z,
                                          std::sqrt(21 / (32 * kPi)) * y * (5 * z * z - 1),
                                          std::sqrt(7 / (16 * kPi)) * z * (5 * z * z - 3),
                                          std::sqrt(21 / (32 * kPi)) * x * (5 * z * z - 1),
                                          std::sqrt(105 / (16 * kPi)) * z * (x * x - y * y),
                                          std::sqrt(35 / (32 * kPi)) * x * (x * x - 3 * y * y)};
    const std::vector<double> values = evaluateSh(4, d);
    ASSERT_EQ(values.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
      EXPECT_NEAR(values[i], expected[i], 1e-14) << "coefficient " << i;
  }
}

class ShOrder : public testing::TestWithParam<int> {};

TEST_P(ShOrder, BasisIsOrthonormal) {
  const int order = GetParam(), count = coefficientCount(order);
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(count, count);
  for (const auto& [direction, weight] : sphereQuadrature(2 * (order - 1))) {
    const std::vector<double> values = evaluateSh(order, direction);
    const Eigen::Map<const Eigen::VectorXd> y(values.data(), count);
    gram += weight * y * y.transpose();
  }
  EXPECT_LT((gram - Eigen::MatrixXd::Identity(count, count)).cwiseAbs().maxCoeff(), 1e-12);
}

TEST_P(ShOrder, ObeysTheAdditionTheorem) {
  const int order = GetParam();
  for (const Vec3& a : someDirections())
    for (const Vec3& b : someDirections()) {
      const std::vector<double> ya = evaluateSh(order, a), yb = evaluateSh(order, b);
      const std::vector<double> p = legendre(order, a.dot(b));
      for (int l = 0; l < order; ++l) {
        double sum = 0;
        for (int m = -l; m <= l; ++m) sum += ya[coefficientIndex(l, m)] * yb[coefficientIndex(l, m)];
        EXPECT_NEAR(sum, (2 * l + 1) / (4 * kPi) * p[l], 1e-12) << "band " << l;
      }
    }
}

// Gauss–Legendre over the upper hemisphere alone is exact, as the clamped cosine is a polynomial there.
TEST_P(ShOrder, ClampedCosineFactorsMatchQuadrature) {
  const int order = GetParam();
  const std::vector<double> factors = clampedCosineFactors(order);
  for (int l = 0; l < order; ++l) {
    double integral = 0;
    for (const auto& [node, weight] : gaussLegendreRule(16)) {
      const double z = (node + 1) / 2;
      integral += weight / 2 * 2 * kPi * z * legendre(order + 1, z)[l];
    }
    EXPECT_NEAR(factors[l], integral, 1e-13) << "band " << l;
  }
}

TEST_P(ShOrder, DiskLightMatchesQuadrature) {
  const int order = GetParam();
  for (const double half_angle : {1e-6, 0.01, 0.5, kPi / 2, 2.0, kPi}) {
    const std::vector<double> zonal = diskLightZonal(order, half_angle);
    for (int l = 0; l < order; ++l) {
      double integral = 0;
      for (const auto& [node, weight] : gaussLegendreRule(16)) {
        // z runs over [cos a, 1]; its length is 2 sin²(a/2).
        const double length = 2 * std::pow(std::sin(half_angle / 2), 2), z = 1 - length * (1 - node) / 2;
        integral +=
            weight * length / 2 * 2 * kPi * std::sqrt((2 * l + 1) / (4 * kPi)) * legendre(order + 1, z)[l];
      }
      // For tiny disks the Legendre difference cancels; an absolute error of a few roundings remains.
      EXPECT_NEAR(zonal[l], integral, 1e-13) << "band " << l << " half angle " << half_angle;
    }
  }
}

TEST_P(ShOrder, OrientedZonalEqualsProjection) {
  const int order = GetParam();
  const Vec3 axis = Vec3(1, -2, 0.5).normalized();
  std::vector<double> zonal(order);
  for (int l = 0; l < order; ++l) zonal[l] = 1.0 / (l + 1);
  const std::vector<double> oriented = orientZonal(zonal, axis);

  std::vector<double> projected(coefficientCount(order), 0.0);
  for (const auto& [direction, weight] : sphereQuadrature(2 * (order - 1))) {
    const std::vector<double> p = legendre(order, axis.dot(direction));
    double value = 0;
    for (int l = 0; l < order; ++l) value += zonal[l] * std::sqrt((2 * l + 1) / (4 * kPi)) * p[l];
    const std::vector<double> basis = evaluateSh(order, direction);
    for (std::size_t i = 0; i < projected.size(); ++i) projected[i] += weight * value * basis[i];
  }
  for (std::size_t i = 0; i < projected.size(); ++i) EXPECT_NEAR(oriented[i], projected[i], 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Orders, ShOrder, testing::Range(1, kMaxOrder + 1));

TEST(Sh, ClampedCosineFactorsAreTheKnownOnes) {
  const std::vector<double> expected = {kPi, 2 * kPi / 3, kPi / 4, 0, -kPi / 24, 0, kPi / 64};
  const std::vector<double> factors = clampedCosineFactors(7);
  for (std::size_t l = 0; l < expected.size(); ++l) EXPECT_NEAR(factors[l], expected[l], 1e-15);
}

TEST(Sh, RefusesOrdersOutOfRange) {
  EXPECT_THROW(evaluateSh(0, Vec3(0, 0, 1)), std::invalid_argument);
  EXPECT_THROW(evaluateSh(kMaxEvaluatedOrder + 1, Vec3(0, 0, 1)), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::transport
