#include "transport/frame.h"

#include <cmath>

namespace bakelight::transport {
namespace {

TEST(Frame, AutomaticExposureBringsUniformLightToTheMiddleValue) {
  for (const float radiance : {1e-3f, 1.0f, 250.0f}) {
    const auto light = uniformLight(3, {radiance, radiance, radiance});
    EXPECT_NEAR(exposureFactor({}, light) * radiance, kMiddleValue, 1e-6) << radiance;
    EXPECT_NEAR(exposureFactor({.exposure_ev = -2}, light) * radiance, kMiddleValue / 4, 1e-6) << radiance;
  }
}

TEST(Frame, ExposureWithoutAutomaticIsAPowerOfTwo) {
  const auto light = uniformLight(1, {9, 9, 9});
  EXPECT_EQ(exposureFactor({.auto_exposure = false, .exposure_ev = 0}, light), 1);
  EXPECT_EQ(exposureFactor({.auto_exposure = false, .exposure_ev = 3}, light), 8);
  EXPECT_EQ(exposureFactor({}, uniformLight(1, {0, 0, 0})), 1) << "no light has no mean to divide by";
}

TEST(Frame, LightTurnsAboutYThenAboutX) {
  const Vec3 turned = worldFromLight({.light_yaw_deg = 90}) * Vec3::UnitZ();
  EXPECT_LT((turned - Vec3::UnitX()).norm(), 1e-12);
  const Vec3 tipped = worldFromLight({.light_pitch_deg = 90}) * Vec3::UnitZ();
  EXPECT_LT((tipped + Vec3::UnitY()).norm(), 1e-12);
  // The yaw takes +Z to +X first, which the pitch leaves; the other order would end at −Y.
  const Vec3 both = worldFromLight({.light_yaw_deg = 90, .light_pitch_deg = 90}) * Vec3::UnitZ();
  EXPECT_LT((both - Vec3::UnitX()).norm(), 1e-12);
}

TEST(Frame, DistanceMultipliesTheFramingDistance) {
  const BoundingSphere bounds{{1, 2, 3}, 2};
  const double framing = frameCamera({}, bounds).distance;
  EXPECT_NEAR(frameCamera({.distance = 2.5}, bounds).distance, 2.5 * framing, 1e-12);
}

TEST(Frame, ObjectTurnsAboutYThenAboutX) {
  const Vec3 turned = worldFromObject({.object_yaw_deg = 90}) * Vec3::UnitZ();
  EXPECT_LT((turned - Vec3::UnitX()).norm(), 1e-12);
  const Vec3 both = worldFromObject({.object_yaw_deg = 90, .object_pitch_deg = 90}) * Vec3::UnitZ();
  EXPECT_LT((both - Vec3::UnitX()).norm(), 1e-12);
  EXPECT_TRUE(worldFromObject({.light_yaw_deg = 30}).isIdentity());
}

}  // namespace
}  // namespace bakelight::transport
