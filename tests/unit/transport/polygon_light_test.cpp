#include "transport/polygon_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "formats/error.h"
#include "transport/directions.h"
#include "transport/gauss_legendre.h"
#include "transport/lights.h"

namespace bakelight::transport {
namespace {

constexpr double kPi = std::numbers::pi;
using Corners = std::vector<Vec3>;

// ∫ y_i over a triangle seen from the origin: dω = |a·(b×c)| du dv / r³ over the plane triangle, by a
// Gauss–Legendre rule on the square that is folded into it.
std::vector<double> triangleQuadrature(int order, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto rule = gaussLegendreRule(48);
  std::vector<double> total(coefficientCount(order), 0.0);
  for (const auto& [x, wx] : rule)
    for (const auto& [y, wy] : rule) {
      const double u = (1 + x) / 2, v = (1 + y) / 2 * (1 - u);
      const Vec3 p = a + u * (b - a) + v * (c - a);
      const double weight = wx * wy / 4 * (1 - u) * std::abs(a.dot(b.cross(c))) / std::pow(p.norm(), 3);
      const auto basis = evaluateSh(order, p.normalized());
      for (std::size_t i = 0; i < total.size(); ++i) total[i] += weight * basis[i];
    }
  return total;
}

std::vector<double> plus(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> sum = a;
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += b.at(i);
  return sum;
}

void expectNear(const std::vector<double>& value, const std::vector<double>& expected, double tolerance) {
  ASSERT_EQ(value.size(), expected.size());
  ASSERT_FALSE(value.empty());
  for (std::size_t i = 0; i < value.size(); ++i)
    EXPECT_NEAR(value[i], expected[i], tolerance) << "coefficient " << i;
}

const std::vector<Corners>& triangles() {
  static const std::vector<Corners> kTriangles = {
      {{1, 0.2, 0.1}, {0.3, 1, 0.2}, {0.1, 0.3, 1.2}},
      {{-2, 0.5, 0.3}, {-1.5, -0.7, 0.2}, {-1, 0.1, 2}},
      {{0.1, -3, 0.2}, {0.2, -3, 0.2}, {0.15, -3, 0.35}},     // 3° wide
      {{0.9, 0.1, 1}, {-0.8, 0.9, 1}, {-0.6, -1.3, 0.9}},     // more than a steradian
      {{5, 1, -2}, {5, 1.0001, -2}, {5.0003, 1.2, -2.0001}},  // a needle
  };
  return kTriangles;
}

TEST(PolygonLight, TriangleEqualsQuadratureAtAllOrders) {
  for (const Corners& t : triangles())
    for (int order = 1; order <= kMaxOrder; ++order)
      expectNear(polygonSh(order, t), triangleQuadrature(order, t[0], t[1], t[2]), 1e-12);
}

TEST(PolygonLight, EitherOrientationIsTheSame) {
  for (Corners corners : triangles()) {
    const auto forward = polygonSh(kMaxOrder, corners);
    EXPECT_GT(forward[0], 0);
    std::reverse(corners.begin(), corners.end());
    expectNear(polygonSh(kMaxOrder, corners), forward, 1e-13);
  }
}

// An L in the plane z = 1: neither convex nor star-shaped from its first corner.
TEST(PolygonLight, PolygonIsTheSumOfItsTriangles) {
  const Corners l = {{0.1, 0.9, 1},  {0.1, -0.5, 1}, {1.2, -0.5, 1},
                     {1.2, -0.1, 1}, {0.5, -0.1, 1}, {0.5, 0.9, 1}};
  const auto triangle = [&](int i, int j, int k) { return polygonSh(kMaxOrder, Corners{l[i], l[j], l[k]}); };
  const auto sum =
      plus(plus(triangle(0, 1, 4), triangle(0, 4, 5)), plus(triangle(1, 2, 3), triangle(1, 3, 4)));
  expectNear(polygonSh(kMaxOrder, l), sum, 1e-13);
}

TEST(PolygonLight, RotationCarriesTheCoefficientsAlong) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(2.1, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  for (const Corners& corners : triangles()) {
    Corners turned;
    for (const Vec3& corner : corners) turned.push_back(turn * corner);
    std::vector<double> rotated(coefficientCount(kMaxOrder));
    ShRotation(kMaxOrder, turn)
        .apply(std::span<const double>(polygonSh(kMaxOrder, corners)), std::span(rotated));
    expectNear(polygonSh(kMaxOrder, turned), rotated, 1e-13);
  }
}

// The regular polygon inside the disk's rim falls short of it by O(1/n²): twice the corners, a quarter of the
// error.
TEST(PolygonLight, RegularPolygonTendsToTheDisk) {
  const Vec3 axis = Vec3(0.3, -0.6, 0.7).normalized(), x = axis.unitOrthogonal(), y = axis.cross(x);
  for (const double half_angle : {0.05, 0.6, 1.3}) {
    const auto disk = orientZonal(diskLightZonal(kMaxOrder, half_angle), axis);
    const auto errorWith = [&](int sides) {
      Corners corners;
      for (int i = 0; i < sides; ++i) {
        const double turn = 2 * kPi * i / sides;
        corners.push_back(std::cos(half_angle) * axis +
                          std::sin(half_angle) * (std::cos(turn) * x + std::sin(turn) * y));
      }
      const auto polygon = polygonSh(kMaxOrder, corners);
      double largest = 0;
      for (std::size_t i = 0; i < disk.size(); ++i)
        largest = std::max(largest, std::abs(polygon[i] - disk[i]));
      return largest;
    };
    const double coarse = errorWith(500), fine = errorWith(1000);
    EXPECT_LT(fine, 2e-5);
    EXPECT_NEAR(coarse / fine, 4, 0.01);
  }
}

TEST(PolygonLight, OctantHasItsClosedForm) {
  const auto octant = polygonSh(5, Corners{Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()});
  EXPECT_NEAR(octant[0], kPi / 2 / std::sqrt(4 * kPi), 1e-15);
  for (int m = -1; m <= 1; ++m)  // ∫ x = ∫ y = ∫ z = π/4
    EXPECT_NEAR(octant[coefficientIndex(1, m)], kPi / 4 * std::sqrt(3 / (4 * kPi)), 1e-14);
  for (const int m : {-2, -1, 1})  // ∫ xy = 1/3
    EXPECT_NEAR(octant[coefficientIndex(2, m)], std::sqrt(15 / kPi) / 2 / 3, 1e-14);
  EXPECT_NEAR(octant[coefficientIndex(2, 0)], 0, 1e-14);
  EXPECT_NEAR(octant[coefficientIndex(2, 2)], 0, 1e-14);
}

TEST(PolygonLight, EightOctantsAreTheSphere) {
  std::vector<double> sum(coefficientCount(kMaxOrder), 0.0);
  for (const double x : {-1, 1})
    for (const double y : {-1, 1})
      for (const double z : {-1, 1})
        sum = plus(sum, polygonSh(kMaxOrder, Corners{{x, 0, 0}, {0, y, 0}, {0, 0, z}}));
  std::vector<double> sphere(sum.size(), 0.0);
  sphere[0] = std::sqrt(4 * kPi);
  expectNear(sum, sphere, 1e-13);
}

// Ω = 4 asin(αβ / √((1+α²)(1+β²))) with half width and height over distance.
TEST(PolygonLight, SolidAngleOfARectangle) {
  for (const double half_width : {1e-3, 0.1, 1.0, 50.0})
    for (const double half_height : {1e-3, 0.3, 8.0}) {
      const Corners corners = {{-half_width, -half_height, -1},
                               {half_width, -half_height, -1},
                               {half_width, half_height, -1},
                               {-half_width, half_height, -1}};
      const double exact =
          4 * std::asin(half_width * half_height /
                        std::sqrt((1 + half_width * half_width) * (1 + half_height * half_height)));
      EXPECT_NEAR(polygonSolidAngle(corners), exact, 1e-12);
    }
}

TEST(PolygonLight, SmallPolygonIsADirection) {
  const Vec3 center(0.4, 0.5, -0.7);
  const Corners corners = {center, center + Vec3(1e-6, 0, 0), center + Vec3(0, 1e-6, 0)};
  const double solid_angle = polygonSolidAngle(corners);
  const auto value = polygonSh(kMaxOrder, corners), basis = evaluateSh(kMaxOrder, center.normalized());
  EXPECT_GT(solid_angle, 1e-13);
  for (std::size_t i = 0; i < value.size(); ++i) EXPECT_NEAR(value[i], solid_angle * basis[i], 2e-15);
}

TEST(PolygonLight, WithoutAreaItIsDark) {
  const std::vector<double> dark(coefficientCount(kMaxOrder), 0.0);
  const Vec3 a(1, 2, 3), b(2, 1, 0.5);
  expectNear(polygonSh(kMaxOrder, Corners{}), dark, 0);
  expectNear(polygonSh(kMaxOrder, Corners{a}), dark, 0);
  expectNear(polygonSh(kMaxOrder, Corners{a, b}), dark, 1e-15);
  expectNear(polygonSh(kMaxOrder, Corners{a, b, a}), dark, 1e-15);
  expectNear(polygonSh(kMaxOrder, Corners{a, a, a, 2 * a}), dark, 1e-15);
  expectNear(polygonSh(kMaxOrder, Corners{a, b, (a + b) / 2}), dark, 1e-15);
}

TEST(PolygonLight, RepeatedCornersChangeNothing) {
  const Corners& t = triangles()[0];
  expectNear(polygonSh(kMaxOrder, Corners{t[0], t[0], t[1], 3 * t[1], t[2]}), polygonSh(kMaxOrder, t), 1e-14);
}

TEST(PolygonLight, RefusesWhatHasNoDirection) {
  EXPECT_THROW(polygonSh(3, Corners{{1, 0, 0}, {0, 0, 0}, {0, 1, 0}}), Error);
  EXPECT_THROW(polygonSh(3, Corners{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}}), Error);
  EXPECT_THROW(PolygonOutline(Corners{{1, 0, -0.1}, {-0.5, 0.9, -0.1}, {-0.5, -0.9, 0.4}, {0, 0, -1}}),
               Error);
}

TEST(PolygonLight, OutlineCoversItsSolidAngle) {
  const auto lattice = sphereDirections(200000);
  for (const Corners& corners : {triangles()[0], triangles()[1], triangles()[3]}) {
    const PolygonOutline outline(corners);
    int inside = 0;
    for (const Vec3& direction : lattice) inside += outline.contains(direction) ? 1 : 0;
    EXPECT_NEAR(4 * kPi * inside / static_cast<double>(lattice.size()), polygonSolidAngle(corners), 2e-3);
    EXPECT_FALSE(outline.contains(-(corners[0] + corners[1] + corners[2]).normalized()));
  }
}

TEST(PolygonLight, LightIsTintedCoefficients) {
  const Corners& corners = triangles()[1];
  const ShLight light = polygonLight(4, corners, {1, 0, 3});
  const auto coefficients = polygonSh(4, corners);
  for (std::size_t i = 0; i < light.size(); ++i) {
    EXPECT_FLOAT_EQ(light[i][0], static_cast<float>(coefficients[i]));
    EXPECT_EQ(light[i][1], 0);
    EXPECT_FLOAT_EQ(light[i][2], static_cast<float>(3 * coefficients[i]));
  }
}

}  // namespace
}  // namespace bakelight::transport
