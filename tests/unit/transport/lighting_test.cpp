#include "transport/lighting.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/error.h"

namespace bakelight::transport {
namespace {

TEST(Lighting, ImageOfTheDefaultLightProjectsBackToIt) {
  // But for what clipping the faintly negative side lobes adds: half a percent of the mean at this order.
  const Lighting lighting = defaultLighting(3);
  const auto projected = projectLatLong(lighting.backdrop, 3, "default");
  ASSERT_EQ(projected.size(), 9u);
  for (std::size_t i = 0; i < 9; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(projected[i][c], lighting.distant[i][c], 0.01 * lighting.distant[0][c]) << i;
}

TEST(Lighting, EnvironmentKeepsColorsWhateverTheirLayerAndOrder) {
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

formats::LightRig rigWithDisk() {
  formats::LightRig rig;
  rig.distant.emplace_back(formats::DiskLight{{0, 1, 0}, 15, {3, 2, 1}});
  return rig;
}

TEST(Lighting, NoLightAtAllIsTheDefaultLight) {
  EXPECT_EQ(lightingFor({}, 3, "").distant, defaultLight(3));
}

TEST(Lighting, AnEnvironmentAloneKeepsItsTexels) {
  formats::LightRig rig;
  formats::EnvironmentLight environment;
  environment.image = formats::Image(4, 2, {"R", "G", "B"});
  environment.image.values.assign(environment.image.values.size(), 0.5F);
  rig.distant.emplace_back(environment);
  EXPECT_EQ(lightingFor(rig, 3, "").backdrop.width, 4);
  std::get<formats::EnvironmentLight>(rig.distant.front()).yaw_deg = 90;
  EXPECT_GT(lightingFor(rig, 3, "").backdrop.width, 4) << "turned: drawn anew";
}

TEST(Lighting, EmittersAloneLeaveDistantLightDark) {
  formats::LightRig rig;
  rig.emitters.emplace_back();
  const Lighting lighting = lightingFromRig(rig, 3, "near.json");
  EXPECT_EQ(lighting.near.emitters.size(), 1u);
  EXPECT_EQ(lighting.distant, uniformLight(3, {0, 0, 0}));
  EXPECT_EQ(lookUpLatLong(lighting.backdrop, {0, 1, 0}), (formats::Float3{0, 0, 0}));
}

TEST(Lighting, WindowMovesEnergyButNotTheMean) {
  formats::LightRig rig = rigWithDisk();
  const Lighting sharp = lightingFromRig(rig, 5, "rig.json");
  EXPECT_EQ(sharp.moved_energy, 0);
  for (const double windowing : {-1.0, 0.01}) {
    rig.windowing = windowing;
    const Lighting soft = lightingFromRig(rig, 5, "rig.json");
    EXPECT_GT(soft.window, 0);
    EXPECT_GT(soft.moved_energy, 0);
    EXPECT_LT(soft.moved_energy, 1);
    EXPECT_EQ(soft.distant[0], sharp.distant[0]);
    EXPECT_LT(std::abs(soft.distant[20][0]), std::abs(sharp.distant[20][0]));
  }
}

TEST(Lighting, WindowOfAnImageIsThatOfTheSameLightInARig) {
  formats::Image image(64, 32, {"R", "G", "B"});
  for (int x = 20; x < 24; ++x) std::fill_n(image.texel(x, 9), 3, 50.0F);
  const Lighting from_image = lightingFromImage(image, 5, "spot.exr", -1);
  formats::LightRig rig;
  formats::EnvironmentLight environment;
  environment.image = image;
  rig.distant.emplace_back(environment);
  rig.windowing = -1;
  const Lighting from_rig = lightingFromRig(rig, 5, "rig.json");
  EXPECT_GT(from_image.window, 0);
  EXPECT_NEAR(from_image.window, from_rig.window, 1e-3 * from_rig.window);
  EXPECT_NEAR(from_image.moved_energy, from_rig.moved_energy, 1e-3);
}

}  // namespace
}  // namespace bakelight::transport
