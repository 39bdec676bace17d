#include "tools/player/frame.h"

#include <cmath>
#include <limits>

#include "formats/error.h"
#include "tools/player/picture_file.h"

namespace bakelight::player {
namespace {

using transport::Vec3;

TEST(Frame, AutomaticExposureBringsUniformLightToTheMiddleValue) {
  for (const float radiance : {1e-3f, 1.0f, 250.0f}) {
    const auto light = transport::uniformLight(3, {radiance, radiance, radiance});
    EXPECT_NEAR(exposureFactor({}, light) * radiance, kMiddleValue, 1e-6) << radiance;
    EXPECT_NEAR(exposureFactor({.exposure_ev = -2}, light) * radiance, kMiddleValue / 4, 1e-6) << radiance;
  }
}

TEST(Frame, ExposureWithoutAutomaticIsAPowerOfTwo) {
  const auto light = transport::uniformLight(1, {9, 9, 9});
  EXPECT_EQ(exposureFactor({.auto_exposure = false, .exposure_ev = 0}, light), 1);
  EXPECT_EQ(exposureFactor({.auto_exposure = false, .exposure_ev = 3}, light), 8);
  EXPECT_EQ(exposureFactor({}, transport::uniformLight(1, {0, 0, 0})), 1)
      << "no light has no mean to divide by";
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
  const transport::BoundingSphere bounds{{1, 2, 3}, 2};
  const double framing = frameCamera({}, bounds).distance;
  EXPECT_NEAR(frameCamera({.distance = 2.5}, bounds).distance, 2.5 * framing, 1e-12);
}

TEST(Frame, ImageOfTheDefaultLightProjectsBackToIt) {
  // But for what clipping the faintly negative side lobes adds: half a percent of the mean at this order.
  const Environment environment = defaultEnvironment(3);
  const auto projected = transport::projectLatLong(environment.image, 3, "default");
  ASSERT_EQ(projected.size(), 9u);
  for (std::size_t i = 0; i < 9; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(projected[i][c], environment.light[i][c], 0.01 * environment.light[0][c]) << i;
}

TEST(Frame, EnvironmentKeepsColoursWhateverTheirLayerAndOrder) {
  formats::Image layered(4, 2, {"sky.B", "sky.G", "sky.R", "sky.Z"});
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x)
      for (std::size_t c = 0; c < 4; ++c) layered.texel(x, y)[c] = static_cast<float>(100 * c + 10 * y + x);
  const Environment environment = environmentFromImage(layered, 1, "layered.exr");
  ASSERT_EQ(environment.image.channelCount(), 3u);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x) {
      EXPECT_NEAR(environment.image.texel(x, y)[0], layered.texel(x, y)[2], 1e-3);
      EXPECT_NEAR(environment.image.texel(x, y)[2], layered.texel(x, y)[0], 1e-3);
    }
}

TEST(Frame, LightThatIsNotFiniteIsAnErrorThatNamesTheFile) {
  formats::Image image(4, 2, {"R", "G", "B"});
  image.texel(2, 1)[1] = std::numeric_limits<float>::quiet_NaN();
  try {
    environmentFromImage(image, 2, "broken.exr");
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    EXPECT_EQ(error.place().file, "broken.exr");
  }
}

TEST(PictureFile, EndingDecidesTheEncoding) {
  EXPECT_EQ(encodingFor("a/b.png"), PictureEncoding::kDisplay);
  EXPECT_EQ(encodingFor("b.EXR"), PictureEncoding::kLinear);
  EXPECT_THROW(encodingFor("b.jpg"), Error);
  EXPECT_THROW(encodingFor("png"), Error);
}

}  // namespace
}  // namespace bakelight::player
