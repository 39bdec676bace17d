#include "tools/reference/distant_light_sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "transport/directions.h"
#include "transport/lights.h"
#include "transport/random.h"
#include "transport/sky.h"

namespace bakelight::reference {
namespace {

constexpr double kPi = std::numbers::pi;

formats::LightRig imageRig(int height, double yaw_deg = 0, double intensity = 1) {
  formats::EnvironmentLight light;
  light.image = formats::Image(2 * height, height, {"R", "G", "B"});
  for (std::size_t i = 0; i < light.image.values.size(); ++i)
    light.image.values[i] = 0.1f + static_cast<float>(transport::scrambled(i) % 1000) * 1e-3f;
  for (int c = 0; c < 3; ++c) light.image.texel(height / 3, height / 4)[c] = 500;
  light.yaw_deg = yaw_deg;
  light.intensity = intensity;
  formats::LightRig rig;
  rig.distant.emplace_back(light);
  return rig;
}

formats::LightRig mixedRig() {
  formats::LightRig rig = imageRig(64, 30, 0.5);
  rig.distant.emplace_back(formats::DiskLight{{0.3f, 1, -0.4f}, 3, {2e3f, 2e3f, 1e3f}});
  rig.distant.emplace_back(formats::DiskLight{{0, -1, 0}, 70, {1, 2, 3}});
  formats::SkyLight sky;
  sky.sun = false;
  rig.distant.emplace_back(sky);
  rig.distant.emplace_back(formats::PolygonLight{{{1, 0.2f, 1}, {1, 1, 1}, {0.2f, 1, 1}}, {4, 5, 6}});
  rig.distant.emplace_back(formats::DirectionalLight{{0, 3, 0}, {7, 8, 9}});
  return rig;
}

class Rig : public testing::TestWithParam<int> {
 protected:
  formats::LightRig rig() const {
    switch (GetParam()) {
      case 0:
        return imageRig(64);
      case 1:
        return imageRig(3);  // blocks of one texel that is far wider than a cell of normals
      case 2:
        return imageRig(200, -77, 3);
      case 3:
        return {};
      default:
        return mixedRig();
    }
  }
};

// E [f / density] over samples is ∫ f over the hemisphere above a surface: the light's irradiance, here
// against directions that fill the sphere evenly; and what a sample says of itself is what towards() says.
TEST_P(Rig, SamplesGiveTheIrradiance) {
  const Eigen::Matrix3d turned = Eigen::AngleAxisd(0.8, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const DistantLightSampler sampler(rig(), turned);
  for (const Vec3& normal : {Vec3(turned * Vec3::UnitY()), Vec3(0.2, -1, 0.4), Vec3(-1, 0, 1e-3)}) {
    const Vec3 n = normal.normalized();
    double sampled = 0, squares = 0;
    constexpr int kBatches = 4000;
    for (int i = 0; i < kBatches; ++i) {
      const transport::StratifiedBatch batch(1, 1, static_cast<std::uint64_t>(i));
      double mean = 0;
      for (int s = 0; s < transport::StratifiedBatch::kSize; ++s) {
        const auto [u, v] = batch.pair(s, 0);
        const auto sample = sampler.sample(n, u, v);
        ASSERT_GT(sample.incident.density_per_sr, 0);
        ASSERT_NEAR(sample.direction.norm(), 1, 1e-12);
        mean += sample.incident.radiance[1] * std::max(0.0, n.dot(sample.direction)) /
                sample.incident.density_per_sr / transport::StratifiedBatch::kSize;
        if (i >= 20) continue;
        const auto again = sampler.towards(sample.direction, n);
        ASSERT_NEAR(again.density_per_sr, sample.incident.density_per_sr, 1e-9 * again.density_per_sr);
        ASSERT_NEAR(again.radiance[2], sample.incident.radiance[2], 1e-9);
        ASSERT_NEAR(sampler.radiance(sample.direction)[0], sample.incident.radiance[0], 1e-9);
      }
      sampled += mean / kBatches;
      squares += mean * mean / kBatches;
    }
    const double error = std::sqrt((squares - sampled * sampled) / kBatches);
    EXPECT_LT(error, 0.015 * sampled);

    double expected = 0;
    static const std::vector<Vec3> directions = transport::sphereDirections(500000);
    for (const Vec3& direction : directions)
      expected += std::max(0.0, n.dot(direction)) * sampler.radiance(direction)[1] * 4 * kPi /
                  static_cast<double>(directions.size());
    EXPECT_NEAR(sampled, expected, 4 * error + 0.004 * expected);
  }
}

// Densities are those of a probability, and there is none where a surface would see light that is never
// sampled.
TEST_P(Rig, DensityIntegratesToOneAndCoversAllLightAbove) {
  const DistantLightSampler sampler(rig(), Eigen::Matrix3d::Identity());
  const std::vector<Vec3> directions = transport::sphereDirections(100000);
  int above = 0;
  for (const Vec3& normal : transport::sphereDirections(12)) {
    double total = 0;
    for (const Vec3& direction : directions) {
      const auto incident = sampler.towards(direction, normal);
      total += incident.density_per_sr * 4 * kPi / static_cast<double>(directions.size());
      if (normal.dot(direction) > 0 && incident.radiance.maxCoeff() > 0) {
        ASSERT_GT(incident.density_per_sr, 0);
        ++above;
      }
    }
    EXPECT_NEAR(total, 1, 0.05);
  }
  EXPECT_GT(above, 30000);
}

INSTANTIATE_TEST_SUITE_P(All, Rig, testing::Range(0, 5));

TEST(DistantLightSampler, TexelsAreConstant) {
  const formats::LightRig rig = imageRig(16);
  const auto& image = std::get<formats::EnvironmentLight>(rig.distant[0]).image;
  const DistantLightSampler sampler(rig, Eigen::Matrix3d::Identity());
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 32; ++x)
      for (const double inside : {0.01, 0.5, 0.99}) {
        const Rgb radiance =
            sampler.radiance(transport::directionOfLatLong((x + inside) / 32, (y + 1 - inside) / 16));
        for (Eigen::Index c = 0; c < 3; ++c) ASSERT_EQ(radiance[c], image.texel(x, y)[c]) << x << " " << y;
      }
}

// Projected by quadrature, the sampler's radiance is the light that the player has.
TEST(DistantLightSampler, IsThePlayersLight) {
  const std::vector<Vec3> directions = transport::sphereDirections(400000);
  const auto project = [&](const formats::LightRig& rig) {
    const DistantLightSampler sampler(rig, Eigen::Matrix3d::Identity());
    std::vector<Rgb> light(9, Rgb::Zero());
    for (const Vec3& direction : directions) {
      const Rgb radiance = sampler.radiance(direction) * 4 * kPi / static_cast<double>(directions.size());
      const auto basis = transport::evaluateSh(3, direction);
      for (std::size_t i = 0; i < 9; ++i) light[i] += radiance * basis[i];
    }
    return light;
  };
  const auto expectSame = [](const std::vector<Rgb>& a, const transport::ShLight& b, double tolerance) {
    for (std::size_t i = 0; i < 9; ++i)
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(a[i][static_cast<Eigen::Index>(c)], b[i][c], tolerance * b[0][c]) << i << " " << c;
  };
  expectSame(project({}), transport::defaultLight(3), 1e-3);
  const formats::LightRig image = imageRig(64);
  expectSame(project(image),
             transport::projectLatLong(std::get<formats::EnvironmentLight>(image.distant[0]).image, 3, ""),
             0.01);
  formats::SkyLight sky;
  sky.sun = false;
  formats::LightRig rig;
  rig.distant.emplace_back(sky);
  expectSame(project(rig), transport::skyLight(transport::Sky(sky), 3), 2e-3);
}

TEST(DistantLightSampler, DirectionalLightsAreListedAndTurned) {
  const Eigen::Matrix3d turned = Eigen::AngleAxisd(kPi / 2, Vec3::UnitX()).toRotationMatrix();
  const DistantLightSampler sampler(mixedRig(), turned);
  ASSERT_EQ(sampler.directional().size(), 1u);
  EXPECT_NEAR((sampler.directional()[0].direction - Vec3::UnitZ()).norm(), 0, 1e-12);
  EXPECT_EQ(sampler.directional()[0].irradiance[2], 9);
}

TEST(DistantLightSampler, DarknessHasNoSamples) {
  formats::LightRig rig;
  rig.distant.emplace_back(formats::DiskLight{{0, -1, 0}, 20, {1, 1, 1}});
  const DistantLightSampler below(rig, Eigen::Matrix3d::Identity());
  EXPECT_EQ(below.sample(Vec3::UnitY(), 0.3, 0.4).incident.density_per_sr, 0);
  rig.distant[0] = formats::DiskLight{{0, 1, 0}, 20, {0, 0, 0}};
  const DistantLightSampler dark(rig, Eigen::Matrix3d::Identity());
  EXPECT_EQ(dark.sample(Vec3::UnitY(), 0.3, 0.4).incident.density_per_sr, 0);
}

}  // namespace
}  // namespace bakelight::reference
