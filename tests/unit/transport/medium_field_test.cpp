// Media that vary: veins are where and as wide as asked, and ways through them have what there is along them.
#include "transport/medium_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

namespace bakelight::transport {
namespace {

const std::vector<Float3> kBox = {{-1, -1, -1}, {1, 1, 1}};

formats::Medium veined(double spacing, double width, int seed = 0) {
  formats::Medium medium{{2, 3, 4}, {0.01F, 0.02F, 0.03F}, 1.4, 1, {}};
  medium.veins = formats::Veins{{1, 1, 1}, {0.3F, 0.4F, 0.5F}, spacing, width, seed};
  return medium;
}

// Of the box's volume.
template <class Function>
double mean(const Function& function, int count = 40, double half = 1) {
  double sum = 0;
  for (int z = 0; z < count; ++z)
    for (int y = 0; y < count; ++y)
      for (int x = 0; x < count; ++x)
        sum += function(half * ((Vec3(x, y, z) + Vec3::Constant(0.5)) * 2 / count - Vec3::Ones()));
  return sum / count / count / count;
}

TEST(MediumField, WithoutVeinsIsOneMedium) {
  formats::Medium medium = veined(1, 0.1);
  medium.veins.reset();
  const MediumField field(medium, kBox);
  EXPECT_TRUE(field.isUniform());
  ASSERT_EQ(field.reflectances().size(), 1U);
  const MediumField::Place way = field.along(Vec3(0, 0, 0), Vec3(1, 0, 0));
  EXPECT_EQ(field.reflectance(1, 0.7, way), field.reflectances()[0][1](0.7));
  EXPECT_EQ(field.shareAt(Vec3::Zero()), 0);
  EXPECT_EQ(field.coefficients(2, 0).extinction(), 4 + double{0.03F});
}

// Sheets: twice as wide is twice the volume; the width is where half is theirs.
TEST(MediumField, VeinsAreAsWideAsAsked) {
  const auto halves = [](double width) {
    const std::vector<Float3> small = {{-0.5F, -0.5F, -0.5F}, {0.5F, 0.5F, 0.5F}};
    const MediumField field(veined(0.4, width), small);
    return mean([&](const Vec3& p) { return field.shareAt(p) >= 0.5 ? 1.0 : 0.0; }, 60, 0.5);
  };
  const double narrow = halves(0.025), wide = halves(0.05);
  EXPECT_NEAR(wide / narrow, 2, 0.15);
  // Area of the sheets per volume, by Rice's formula for slopes of all directions: 2 · mean slope · density of the height 0. The noise's, measured: mean slope
  // 2.55, root mean square of the height 0.34, nearly normal.
  const double area = 2.55 / 0.4 / (0.342 * std::sqrt(2 * std::numbers::pi));
  EXPECT_NEAR(narrow / 0.025 / area, 1, 0.25);
}

TEST(MediumField, SeedsPutVeinsElsewhere) {
  const MediumField one(veined(0.6, 0.1, 1), kBox), other(veined(0.6, 0.1, 2), kBox),
      same(veined(0.6, 0.1, 1), kBox);
  EXPECT_GT(mean([&](const Vec3& p) { return std::abs(one.shareAt(p) - other.shareAt(p)); }), 0.1);
  EXPECT_EQ(mean([&](const Vec3& p) { return std::abs(one.shareAt(p) - same.shareAt(p)); }), 0);
}

// The mean of what lies on its line, more or less: it is that of a tube.
TEST(MediumField, WaysHaveWhatLiesAlongThem) {
  const MediumField field(veined(0.6, 0.1), kBox);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-1, 1);
  double products = 0, tube_squares = 0, line_squares = 0, both = 0, lines = 0;
  constexpr int kWays = 400, kPoints = 200;
  const auto shareOf = [&](const MediumField::Place& way) {  // nodes are squares
    const double low = way.node / (MediumField::kNodes - 1.0),
                 high = (way.node + 1) / (MediumField::kNodes - 1.0);
    return low * low + static_cast<double>(way.share) * (high * high - low * low);
  };
  for (int i = 0; i < kWays; ++i) {
    const Vec3 from(place(random), place(random), place(random));
    const Vec3 to = from + 0.3 * Vec3(place(random), place(random), place(random));
    double line = 0;
    for (int k = 0; k < kPoints; ++k)
      line += field.shareAt(from + (k + 0.5) / kPoints * (to - from)) / kPoints;
    const MediumField::Place way = field.along(from, to), back = field.along(to, from);
    EXPECT_NEAR(shareOf(way), shareOf(back), 1e-5);
    const double tube = shareOf(way);
    both += tube, lines += line;
    products += tube * line, tube_squares += tube * tube, line_squares += line * line;
  }
  EXPECT_NEAR(both / lines, 1, 0.03);
  const double n = kWays, covariance = products / n - both / n * lines / n;
  EXPECT_GT(covariance / std::sqrt((tube_squares / n - both / n * both / n) *
                                   (line_squares / n - lines / n * lines / n)),
            0.9);
}

TEST(MediumField, SharesMixCoefficients) {
  const MediumField field(veined(0.6, 0.1), kBox);
  EXPECT_NEAR(field.coefficients(0, 0.25).reduced_scattering, 1.75, 1e-6);
  EXPECT_NEAR(field.coefficients(0, 0.25).absorption, 0.01 + 0.25 * 0.29, 1e-6);
  const DiffuseReflectance mixed(formats::DiffusionModel::kDipole, field.coefficients(1, 0.3));
  EXPECT_NEAR(field.reflectance(1, 0.4, MediumField::placeOf(0.3)) / mixed(0.4), 1, 0.02);
  for (const double share : {0.0, 1.0})
    EXPECT_EQ(field.reflectance(1, 0.4, MediumField::placeOf(share)),
              DiffuseReflectance(formats::DiffusionModel::kDipole, field.coefficients(1, share))(0.4));
}

TEST(MediumField, TurnsWithItsObject) {
  const Eigen::Isometry3d turn(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
  const Eigen::Isometry3d here_from_object = Eigen::Translation3d(0.1, 0.2, 0.3) * turn;
  std::vector<Float3> turned;
  for (const Float3& corner : kBox) turned.push_back(float3(here_from_object * vec3(corner)));
  const MediumField field(veined(0.6, 0.1), kBox);
  const MediumField moved(veined(0.6, 0.1), turned, here_from_object.inverse());
  EXPECT_LT(
      mean([&](const Vec3& p) { return std::abs(field.shareAt(p) - moved.shareAt(here_from_object * p)); }),
      1e-5);
}

TEST(MediumField, ThinnerVeinsThanCellsAreRefused) {
  EXPECT_NO_THROW(MediumField(veined(0.5, 0.1), kBox));
  EXPECT_THROW(MediumField(veined(0.5, 0.002), kBox), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::transport
