#include "tools/player/lighting.h"

#include <cmath>
#include <limits>

#include "formats/error.h"

namespace bakelight::player {
namespace {

TEST(Lighting, ImageOfTheDefaultLightProjectsBackToIt) {
  // But for what clipping the faintly negative side lobes adds: half a percent of the mean at this order.
  const Lighting lighting = defaultLighting(3);
  const auto projected = transport::projectLatLong(lighting.backdrop, 3, "default");
  ASSERT_EQ(projected.size(), 9u);
  for (std::size_t i = 0; i < 9; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(projected[i][c], lighting.distant[i][c], 0.01 * lighting.distant[0][c]) << i;
}

TEST(Lighting, EnvironmentKeepsColoursWhateverTheirLayerAndOrder) {
  formats::Image layered(4, 2, {"sky.B", "sky.G", "sky.R", "sky.Z"});
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x)
      for (std::size_t c = 0; c < 4; ++c) layered.texel(x, y)[c] = static_cast<float>(100 * c + 10 * y + x);
  const Lighting lighting = lightingFromImage(layered, 1, "layered.exr");
  ASSERT_EQ(lighting.backdrop.channelCount(), 3u);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x) {
      EXPECT_NEAR(lighting.backdrop.texel(x, y)[0], layered.texel(x, y)[2], 1e-3);
      EXPECT_NEAR(lighting.backdrop.texel(x, y)[2], layered.texel(x, y)[0], 1e-3);
    }
}

TEST(Lighting, LightThatIsNotFiniteIsAnErrorThatNamesTheFile) {
  formats::Image image(4, 2, {"R", "G", "B"});
  image.texel(2, 1)[1] = std::numeric_limits<float>::quiet_NaN();
  try {
    lightingFromImage(image, 2, "broken.exr");
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    EXPECT_EQ(error.place().file, "broken.exr");
  }
}

}  // namespace
}  // namespace bakelight::player
