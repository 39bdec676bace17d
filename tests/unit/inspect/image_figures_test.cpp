#include "tools/inspect/image_figures.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace bakelight::inspect {
namespace {

using formats::Image;

Image uniformProbe(float value) {
  Image image(64, 32, {"R", "G", "B"});
  for (float& v : image.values) v = value;
  return image;
}

TEST(ImageFigures, ChannelsCountWhatIsNotFinite) {
  Image image(2, 2, {"A", "Z"});
  image.values = {1, 0, 2, std::nanf(""), 3, std::numeric_limits<float>::infinity(), 6, -4};
  const auto channels = measureChannels(image);
  ASSERT_EQ(channels.size(), 2U);
  EXPECT_EQ(channels[0].minimum(), 1);
  EXPECT_EQ(channels[0].mean(), 3);
  EXPECT_EQ(channels[0].maximum(), 6);
  EXPECT_EQ(channels[0].nanCount() + channels[0].infiniteCount(), 0U);
  EXPECT_EQ(channels[1].nanCount(), 1U);
  EXPECT_EQ(channels[1].infiniteCount(), 1U);
  EXPECT_EQ(channels[1].mean(), -2);
  EXPECT_DOUBLE_EQ(channels[1].rootMeanSquare(), std::sqrt(8.0));
}

TEST(ImageFigures, ColorChannelsAreFoundUnderAnyLayer) {
  EXPECT_EQ(colorChannels(Image(1, 1, {"C.B", "C.G", "C.R"})), (std::array<std::size_t, 3>{2, 1, 0}));
  EXPECT_EQ(colorChannels(Image(1, 1, {"Y"})), (std::array<std::size_t, 3>{0, 0, 0}));
  EXPECT_EQ(colorChannels(Image(1, 1, {"sh00", "sh01"})), std::nullopt);
}

TEST(ImageFigures, AUniformProbeHasItsRadianceAsMeanAndNoRange) {
  const auto probe = measureProbe(uniformProbe(0.5f), "probe.exr");
  ASSERT_TRUE(probe);
  for (const double mean : probe->mean_radiance) EXPECT_NEAR(mean, 0.5, 1e-6);
  EXPECT_EQ(probe->dynamic_range_stops, 0);
}

TEST(ImageFigures, ASunIsFoundAndCountsByItsSolidAngle) {
  Image image = uniformProbe(1);
  const int x = 8, y = 10;  // an eighth from the left: longitude 135° from +Z towards +X
  image.texel(x, y)[0] = image.texel(x, y)[1] = image.texel(x, y)[2] = 1025;
  const auto probe = measureProbe(image, "probe.exr");
  ASSERT_TRUE(probe);
  EXPECT_NEAR(probe->dynamic_range_stops, std::log2(1025), 1e-9);

  const double pi = std::numbers::pi;
  const double top = pi * (0.5 - y / 32.0), bottom = pi * (0.5 - (y + 1) / 32.0);
  const double solid_angle_sr = 2 * pi / 64 * (std::sin(top) - std::sin(bottom));
  EXPECT_NEAR(probe->mean_radiance[1], 1 + 1024 * solid_angle_sr / (4 * pi), 1e-5);
  const double latitude = pi * (0.5 - 10.5 / 32), longitude = pi * (1 - 2 * 8.5 / 64);
  EXPECT_NEAR(probe->brightest_direction.x(), std::cos(latitude) * std::sin(longitude), 1e-12);
  EXPECT_NEAR(probe->brightest_direction.y(), std::sin(latitude), 1e-12);
  EXPECT_NEAR(probe->brightest_direction.z(), std::cos(latitude) * std::cos(longitude), 1e-12);
}

TEST(ImageFigures, OtherShapesAreNoProbes) {
  EXPECT_FALSE(measureProbe(Image(32, 32, {"R", "G", "B"}), "a"));
  EXPECT_FALSE(measureProbe(Image(64, 32, {"id", "depth"}), "a"));
  EXPECT_FALSE(measureProbe(uniformProbe(0), "a"));
  EXPECT_FALSE(measureProbe(uniformProbe(std::nanf("")), "a"));
}

}  // namespace
}  // namespace bakelight::inspect
