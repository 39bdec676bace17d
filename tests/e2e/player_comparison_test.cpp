#include "tests/e2e/player_comparison.h"

#include <cmath>

#include "formats/image.h"
#include "tests/e2e/made_packs.h"
#include "transport/lights.h"

namespace bakelight::tests {
namespace {

namespace fs = std::filesystem;

const fs::path kPlayer = fs::path(BAKELIGHT_BIN_DIR) / "player";

// Coloured waves of fine and coarse detail, and a sun a hundred times brighter.
formats::Image skyWithSun() {
  formats::Image sky(256, 128, {"R", "G", "B"});
  const transport::Vec3 sun = transport::Vec3(0.4, 0.5, -0.8).normalized();
  for (int y = 0; y < sky.height; ++y)
    for (int x = 0; x < sky.width; ++x) {
      const auto direction = transport::directionOfLatLong((x + 0.5) / sky.width, (y + 0.5) / sky.height);
      float* texel = sky.texel(x, y);
      for (int c = 0; c < 3; ++c)
        texel[c] =
            static_cast<float>(0.6 + 0.3 * direction[c] + 0.2 * std::sin(0.3 * x + c) * std::sin(0.4 * y) +
                               (direction.dot(sun) > 0.995 ? 60 : 0));
    }
  return sky;
}

class PlayerAgainstCpu : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / ("bakelight-e2e-" + std::string(test->name()));
    fs::create_directories(folder_);
    formats::writeExr(folder_ / "sky.exr", skyWithSun(), formats::ExrPrecision::kFloat);
  }
  void TearDown() override {
    if (!HasFailure()) fs::remove_all(folder_);
  }

  void expectAgreement(const formats::Pack& pack, const player::FrameSettings& settings,
                       bool with_sky = true) {
    formats::writePack(folder_ / "made.glb", pack, {});
    const auto result = comparePlayerWithCpu(kPlayer, folder_ / "made.glb",
                                             with_sky ? folder_ / "sky.exr" : fs::path(), settings, folder_);
    EXPECT_TRUE(result.agrees()) << result.summary() << "; pictures in " << folder_;
    RecordProperty("comparison", result.summary());
    std::printf("%s\n", result.summary().c_str());
  }

  fs::path folder_;
};

TEST_F(PlayerAgainstCpu, DefaultFrame) {
  expectAgreement(wavyPack(5, 96), {});
}

TEST_F(PlayerAgainstCpu, DefaultLight) {
  expectAgreement(wavyPack(4, 64), {.width_px = 640, .height_px = 480}, false);
}

// Yaw and pitch of camera and light all at once, so that a wrong order of rotations shows.
TEST_F(PlayerAgainstCpu, TurnedCameraAndLight) {
  expectAgreement(wavyPack(10, 64), {.width_px = 480,
                                     .height_px = 640,
                                     .supersampling = 3,
                                     .yaw_deg = -130,
                                     .pitch_deg = 40,
                                     .distance = 0.8,
                                     .field_of_view_deg = 50,
                                     .light_yaw_deg = 70,
                                     .light_pitch_deg = -35,
                                     .exposure_ev = -1});
}

TEST_F(PlayerAgainstCpu, TransparentBackground) {
  expectAgreement(wavyPack(3, 64), {.width_px = 400,
                                    .height_px = 300,
                                    .supersampling = 1,
                                    .background = player::Background::kTransparent});
}

}  // namespace
}  // namespace bakelight::tests
