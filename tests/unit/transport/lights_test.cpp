#include "transport/lights.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <numbers>

#include "formats/error.h"
#include "tests/unit/transport/quadrature.h"
#include "transport/evaluator.h"

namespace bakelight::transport {
namespace {

constexpr double kPi = std::numbers::pi;

formats::Image probe(int height, const std::function<Float3(const Vec3&)>& radiance) {
  formats::Image image(2 * height, height, {"R", "G", "B"});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Float3 value = radiance(directionOfLatLong((x + 0.5) / image.width, (y + 0.5) / height));
      std::copy(value.begin(), value.end(), image.texel(x, y));
    }
  return image;
}

TEST(LatLong, OrientationIsThatOfOpenExr) {
  const auto expect = [](double u, double v, const Vec3& direction) {
    EXPECT_LT((directionOfLatLong(u, v) - direction).norm(), 1e-12) << u << ", " << v;
  };
  expect(0.5, 0.5, Vec3(0, 0, 1));
  expect(0.25, 0.5, Vec3(1, 0, 0));
  expect(0.75, 0.5, Vec3(-1, 0, 0));
  expect(0.0, 0.5, Vec3(0, 0, -1));
  expect(0.5, 0.0, Vec3(0, 1, 0));
}

TEST(LatLong, DirectionAndCoordinatesAreInverse) {
  for (double u = 0.01; u < 1; u += 0.07)
    for (double v = 0.01; v < 1; v += 0.07) {
      const auto [back_u, back_v] = latLongOfDirection(directionOfLatLong(u, v));
      EXPECT_NEAR(back_u, u, 1e-12);
      EXPECT_NEAR(back_v, v, 1e-12);
    }
}

// ∫ 1 · y_00 = √(4π) to rounding: the texels' solid angles are exact.
TEST(LatLong, UniformProbeIsTheUniformLight) {
  const ShLight light = projectLatLong(probe(64,
                                             [](const Vec3&) {
                                               return Float3{1, 2, 3};
                                             }),
                                       5, "made by the test");
  const ShLight expected = uniformLight(5, {1, 2, 3});
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(light[0][c], expected[0][c], 1e-6 * expected[0][c]);
  // Bands above vanish up to the midpoint rule's error, O(1/height²).
  for (std::size_t i = 1; i < light.size(); ++i) EXPECT_NEAR(light[i][0], 0, 2e-3) << "coefficient " << i;
}

TEST(LatLong, BandLimitedProbeComesBack) {
  const int order = 4;
  for (int i = 0; i < coefficientCount(order); ++i) {
    const auto image = probe(256, [&](const Vec3& d) {
      const auto value = static_cast<float>(evaluateSh(order, d)[i]);
      return Float3{value, 0, -2 * value};
    });
    const ShLight light = projectLatLong(image, order, "made by the test");
    for (int j = 0; j < coefficientCount(order); ++j) {
      // Midpoint rule in latitude with 256 rows: about (π/256)² of the second derivative.
      EXPECT_NEAR(light[j][0], i == j ? 1 : 0, 1e-3);
      EXPECT_NEAR(light[j][2], i == j ? -2 : 0, 2e-3);
    }
  }
}

TEST(LatLong, DiskProbeIsTheDiskLight) {
  const Vec3 axis = Vec3(0.3, 0.8, -0.5).normalized();
  const double half_angle = 0.4;
  const auto image = probe(512, [&](const Vec3& d) {
    const float inside = d.dot(axis) > std::cos(half_angle) ? 5.0f : 0.0f;
    return Float3{inside, inside, inside};
  });
  const ShLight projected = projectLatLong(image, 6, "made by the test");
  const ShLight expected = diskLight(6, axis, half_angle, {5, 5, 5});
  // The disk's edge crosses texels of π/512 rad: an error of the order of a quarter texel of its rim.
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(projected[i][1], expected[i][1], 5e-3);
}

TEST(LatLong, SameBytesWithAnyNumberOfThreads) {
  const auto image = probe(33, [](const Vec3& d) {
    return Float3{float(d.x() + 2), float(d.y() * d.y()), 1};
  });
  const ShLight many = projectLatLong(image, 7, "made by the test");
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(projectLatLong(image, 7, "made by the test"), many);
}

TEST(LatLong, LookUpInterpolatesAndWraps) {
  formats::Image image(8, 4, {"R", "G", "B"});
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 8; ++x) image.texel(x, y)[0] = static_cast<float>(x);
  EXPECT_NEAR(lookUpLatLong(image, directionOfLatLong(2.5 / 8, 0.5))[0], 2, 1e-5);
  EXPECT_NEAR(lookUpLatLong(image, directionOfLatLong(3.0 / 8, 0.5))[0], 2.5, 1e-5);
  // Halfway between the last and the first column, across the seam.
  EXPECT_NEAR(lookUpLatLong(image, directionOfLatLong(1e-12, 0.5))[0], 3.5, 1e-5);
}

TEST(LatLong, RefusesOtherShapesAndChannels) {
  EXPECT_THROW(projectLatLong(formats::Image(10, 10, {"R", "G", "B"}), 3, "square.exr"), Error);
  EXPECT_THROW(projectLatLong(formats::Image(8, 4, {"R", "Z", "B"}), 3, "strange.exr"), Error);
  EXPECT_NO_THROW(
      projectLatLong(formats::Image(8, 4, {"Combined.R", "Combined.G", "Combined.B"}), 3, "layer.exr"));
  EXPECT_NO_THROW(projectLatLong(formats::Image(8, 4, {"Y"}), 3, "grey.exr"));
}

TEST(Lights, RotatingADiskMovesItsAxis) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.1, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  const Vec3 axis = Vec3(0, 1, 0.2).normalized();
  const ShLight rotated = ShRotation(6, turn).apply(diskLight(6, axis, 0.3, {1, 2, 3}));
  const ShLight expected = diskLight(6, turn * axis, 0.3, {1, 2, 3});
  for (std::size_t i = 0; i < expected.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(rotated[i][c], expected[i][c], 1e-6);
}

// ∫ y_lm over the disk, by Gauss–Legendre between its edge and its centre and equal steps around it.
TEST(Lights, DiskEqualsQuadratureAtAllOrdersAndAngles) {
  const auto heights = gaussLegendreRule(12);  // exact to degree 23
  constexpr int kColumns = 24;
  for (const double half_angle : {0.0, 1e-4, 0.005, 0.3, 1.0, kPi / 2, 2.0, 3.0, kPi}) {
    const double edge = std::cos(half_angle), half_height = std::pow(std::sin(half_angle / 2), 2);
    for (int order = 1; order <= kMaxOrder; ++order) {
      std::vector<double> integral(coefficientCount(order), 0.0);
      for (const auto& [x, weight] : heights)
        for (int column = 0; column < kColumns; ++column) {
          const double z = edge + (1 + x) * half_height, r = std::sqrt(std::max(0.0, 1 - z * z));
          const double phi = 2 * kPi * (column + 0.5) / kColumns;
          const auto basis = evaluateSh(order, Vec3(r * std::cos(phi), r * std::sin(phi), z));
          for (std::size_t i = 0; i < integral.size(); ++i)
            integral[i] += basis[i] * weight * half_height * 2 * kPi / kColumns;
        }
      const auto disk = orientZonal(diskLightZonal(order, half_angle), Vec3::UnitZ());
      for (std::size_t i = 0; i < disk.size(); ++i)
        EXPECT_NEAR(disk[i], integral[i], 1e-12) << half_angle << ", coefficient " << i;
    }
  }
}

// A surface facing a disk of half angle a and radiance 1 has irradiance π sin² a. What truncation leaves
// falls with the square of the order: 5e-3 at order 10, 1.1e-3 at 19.
TEST(Lights, DiskIrradianceIsTheConfigurationFactor) {
  const int order = kMaxEvaluatedOrder;
  for (const double half_angle : {0.3, 0.8, 1.4}) {
    const std::vector<double> factors = clampedCosineFactors(order),
                              zonal = diskLightZonal(order, half_angle);
    double irradiance = 0;
    for (int l = 0; l < order; ++l) irradiance += factors[l] * std::sqrt((2 * l + 1) / (4 * kPi)) * zonal[l];
    EXPECT_NEAR(irradiance, kPi * std::pow(std::sin(half_angle), 2), 2e-3);
  }
}

}  // namespace
}  // namespace bakelight::transport
