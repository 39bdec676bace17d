#include "transport/sky.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "transport/directions.h"

namespace bakelight::transport {
namespace {

constexpr double kPi = std::numbers::pi;

double luminance(const Sky::Rgb& rgb) {
  return transport::luminance(float3(rgb.matrix()));
}

formats::SkyLight skyWith(double turbidity, double sun_elevation_deg, double sun_azimuth_deg = 0) {
  formats::SkyLight light;
  light.turbidity = turbidity;
  light.sun_elevation_deg = sun_elevation_deg;
  light.sun_azimuth_deg = sun_azimuth_deg;
  return light;
}

// kcd/m², by hand from the paper's zenith formula.
TEST(Sky, ZenithHasThePapersLuminance) {
  EXPECT_NEAR(luminance(Sky(skyWith(3, 40)).radiance(Vec3::UnitY())), 6.52, 0.03);
  EXPECT_NEAR(luminance(Sky(skyWith(2, 20)).radiance(Vec3::UnitY())), 2.941, 0.02);
}

// Two directions, evaluated from the paper's tables by a script of a few lines.
TEST(Sky, RadianceIsThatOfThePapersFormulas) {
  const auto expectRgb = [](const Sky& sky, double elevation, double azimuth, const Sky::Rgb& expected) {
    const double e = elevation * kPi / 180, a = azimuth * kPi / 180;
    const Vec3 direction(std::cos(e) * std::sin(a), std::sin(e), std::cos(e) * std::cos(a));
    EXPECT_LT((sky.radiance(direction) - expected).abs().maxCoeff(), 1e-4) << sky.radiance(direction);
  };
  expectRgb(Sky(skyWith(3, 30, 25)), 50, 205, {2.312542, 4.469322, 8.483146});
  expectRgb(Sky(skyWith(5, 60, 25)), 20, 25, {15.841702, 17.473832, 21.016032});
}

// A clear day: some 100 klx from the highest sun on a surface that faces it, 60 to 90 klx from one at 40°,
// and 10 to 30 klx of the sky on the ground.
TEST(Sky, SunAndSkyIlluminateAsOnAClearDay) {
  const auto illuminance = [](double turbidity, double elevation) {
    return luminance(Sky(skyWith(turbidity, elevation)).sunRadiance()) * kPi *
           std::pow(std::sin(kSunHalfAngle_rad), 2);
  };
  EXPECT_NEAR(illuminance(2, 90), 100, 4);
  EXPECT_GT(illuminance(3, 40), 60);
  EXPECT_LT(illuminance(3, 40), 90);
  EXPECT_LT(illuminance(3, 10), illuminance(3, 40));
  EXPECT_LT(illuminance(6, 40), illuminance(3, 40));

  formats::SkyLight without_sun = skyWith(3, 40);
  without_sun.sun = false;
  without_sun.ground_albedo = {1, 1, 1};
  const double sky_klx = luminance(Sky(without_sun).groundRadiance()) * kPi;
  EXPECT_GT(sky_klx, 10);
  EXPECT_LT(sky_klx, 30);
}

TEST(Sky, IsBlueAwayFromTheSunAndTheLowSunIsRed) {
  const Sky::Rgb away = Sky(skyWith(2.5, 40)).radiance(Vec3(0, 0.7, -0.7).normalized());
  EXPECT_GT(away[2], 1.3 * away[0]);
  const Sky::Rgb low = Sky(skyWith(3, 3)).sunRadiance(), high = Sky(skyWith(3, 60)).sunRadiance();
  EXPECT_GT(low[0] / low[1], 1.5 * high[0] / high[1]);
  // Behind one air mass sunlight is about CIE D55: in linear sRGB 1.12 : 1 : 0.83.
  const Sky::Rgb zenith = Sky(skyWith(2, 90)).sunRadiance();
  EXPECT_NEAR(zenith[0] / zenith[1], 1.12, 0.07);
  EXPECT_NEAR(zenith[2] / zenith[1], 0.83, 0.07);
}

TEST(Sky, IsFiniteAndNotNegativeEverywhere) {
  const auto lattice = sphereDirections(400);
  int compared = 0;
  for (const double turbidity : {1.7, 2.0, 3.0, 6.0, 10.0})
    for (const double elevation : {-90.0, -10.0, -0.01, 0.0, 0.01, 0.3, 1.0, 5.0, 30.0, 60.0, 89.0, 90.0}) {
      const Sky sky(skyWith(turbidity, elevation, 33));
      std::vector<Vec3> directions = lattice;
      directions.insert(directions.end(), {Vec3::UnitY(), -Vec3::UnitY(), Vec3::UnitX(), sky.sunDirection(),
                                           -sky.sunDirection()});
      for (const Vec3& direction : directions) {
        const Sky::Rgb radiance = sky.radiance(direction);
        ASSERT_TRUE(radiance.allFinite() && radiance.minCoeff() >= 0)
            << "turbidity " << turbidity << ", sun at " << elevation << ": " << radiance.transpose();
        ++compared;
      }
      ASSERT_TRUE(sky.sunRadiance().allFinite() && sky.sunRadiance().minCoeff() >= 0);
      ASSERT_TRUE(sky.groundRadiance().allFinite() && sky.groundRadiance().minCoeff() >= 0);
      EXPECT_EQ(luminance(sky.radiance(Vec3::UnitY())) > 0, elevation >= 0) << elevation;
    }
  EXPECT_EQ(compared, 5 * 12 * 405);
}

TEST(Sky, GroundSendsBackWhatFallsOnIt) {
  formats::SkyLight light = skyWith(4, 35, 120);
  light.ground_albedo = {0.1F, 0.5F, 1};
  const Sky sky(light);
  Sky::Rgb irradiance = Sky::Rgb::Zero();
  const auto lattice = sphereDirections(200000);
  for (const Vec3& direction : lattice)
    if (direction.y() > 0)
      irradiance += sky.radiance(direction) * direction.y() * 4 * kPi / static_cast<double>(lattice.size());
  irradiance += sky.sunRadiance() * kPi * std::pow(std::sin(kSunHalfAngle_rad), 2) * sky.sunDirection().y();
  const Sky::Rgb expected = irradiance / kPi * Sky::Rgb(0.1, 0.5, 1);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sky.groundRadiance()[c], expected[c], 1e-4 * expected[c]);
  EXPECT_EQ((sky.radiance(Vec3(0.5, -0.1, 0)) - sky.groundRadiance()).abs().maxCoeff(), 0);
}

TEST(Sky, AzimuthRotatesTheLight) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(70 * kPi / 180, Vec3::UnitY()).toRotationMatrix();
  const ShLight turned = ShRotation(8, turn).apply(skyLight(Sky(skyWith(3, 25, 0)), 8));
  const ShLight expected = skyLight(Sky(skyWith(3, 25, 70)), 8);
  // +Z turns towards +X. What the quadrature misses at the cusp around the sun shows here.
  for (std::size_t i = 0; i < expected.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(turned[i][c], expected[i][c], 2e-5 * expected[0][c]);
}

TEST(Sky, ProjectionIsTheIntegralOfTheRadiance) {
  formats::SkyLight light = skyWith(2.5, 20, 200);
  light.sun = false;
  const Sky sky(light);
  const int order = 6;
  std::vector<Sky::Rgb> integral(coefficientCount(order), Sky::Rgb::Zero());
  const auto lattice = sphereDirections(400000);
  for (const Vec3& direction : lattice) {
    const auto basis = evaluateSh(order, direction);
    const Sky::Rgb radiance = sky.radiance(direction);
    for (std::size_t i = 0; i < basis.size(); ++i) integral[i] += basis[i] * radiance;
  }
  const ShLight projected = skyLight(sky, order);
  // The lattice sees the horizon as a step: about 1/√n of a coefficient.
  for (std::size_t i = 0; i < integral.size(); ++i)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(projected[i][c], integral[i][c] * 4 * kPi / static_cast<double>(lattice.size()),
                  2e-4 * projected[0][c]);
}

TEST(Sky, IntensityAndSunSwitchDoWhatTheySay) {
  formats::SkyLight light = skyWith(3, 40);
  const ShLight with_sun = skyLight(Sky(light), 4);
  light.intensity = 2.5;
  const ShLight bright = skyLight(Sky(light), 4);
  for (std::size_t i = 0; i < bright.size(); ++i)
    EXPECT_NEAR(bright[i][1], 2.5 * with_sun[i][1], 1e-5 * bright[0][1]);
  light.intensity = 1;
  light.sun = false;
  light.ground_albedo = {0, 0, 0};
  EXPECT_EQ(Sky(light).sunRadiance().maxCoeff(), 0);
  EXPECT_LT(skyLight(Sky(light), 1)[0][1], with_sun[0][1]);
}

}  // namespace
}  // namespace bakelight::transport
