#include "tools/light/light.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <numbers>

#include "formats/file.h"
#include "tests/support/temporary_folder.h"

namespace bakelight::light {
namespace {

constexpr double kPi = std::numbers::pi;

formats::LightRig rigOf(std::vector<formats::DistantLight> lights, double windowing = 0) {
  formats::LightRig rig;
  rig.distant = std::move(lights);
  rig.windowing = windowing;
  return rig;
}

TEST(Light, SharesAddUpAndNameTheirLights) {
  const double half_angle = 20 * kPi / 180;
  const auto rig = rigOf({formats::DiskLight{.half_angle_deg = 20, .radiance = {2, 2, 2}},
                          formats::DirectionalLight{.irradiance = {0.5F, 0.5F, 0.5F}}});
  const auto light = transport::distantLight(rig, 4);
  const LightFigures figures = figuresOf(rig, light.light);
  ASSERT_EQ(figures.lights.size(), 2u);
  const double disk = 2 * 2 * kPi * (1 - std::cos(half_angle));
  EXPECT_EQ(figures.lights[0].type, "disk");
  EXPECT_NEAR(figures.lights[0].scalar_irradiance[0], disk, 1e-6);
  EXPECT_EQ(figures.lights[1].type, "directional");
  EXPECT_NEAR(figures.lights[1].scalar_irradiance[2], 0.5, 1e-6);
  EXPECT_NEAR(figures.lights[0].energy_share, disk / (disk + 0.5), 1e-6);
  EXPECT_NEAR(figures.lights[0].energy_share + figures.lights[1].energy_share, 1, 1e-12);
  EXPECT_NEAR(figures.mean_radiance[1], (disk + 0.5) / (4 * kPi), 1e-6);
}

TEST(Light, MinimumTellsOfRinging) {
  const auto minimum = [](const formats::LightRig& rig) {
    return figuresOf(rig, transport::distantLight(rig, 5).light).minimum_over_mean;
  };
  const formats::DirectionalLight sun;
  EXPECT_LT(minimum(rigOf({sun})), -1);
  EXPECT_NEAR(minimum(rigOf({sun}, -1)), -0.02, 1e-3);
  EXPECT_NEAR(minimum(rigOf({formats::DiskLight{.half_angle_deg = 180}})), 1, 1e-5);
  EXPECT_EQ(minimum(rigOf({})), 0);
}

TEST(Light, TensorHoldsCoefficientsByColor) {
  const auto rig = rigOf({formats::DiskLight{.radiance = {1, 2, 3}}}, 0.01);
  const auto light = transport::distantLight(rig, 3);
  const formats::TensorFile file = tensorFile(light, 3);
  const auto values = file.require("light", formats::ElementType::kFloat32, 2, "test").as<float>();
  EXPECT_EQ(file.tensors.at("light").shape, (std::vector<std::uint64_t>{9, 3}));
  for (std::size_t i = 0; i < 9; ++i)
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(values[3 * i + c], light.light[i][c]);
  EXPECT_EQ(file.metadata.at("order"), "3");
  EXPECT_EQ(file.metadata.at("basis"), "real_sh_cartesian");
  EXPECT_EQ(file.metadata.at("window"), "0.01");
}

TEST(Light, PreviewShowsTheLightsAboveTheirReconstruction) {
  const auto light = transport::distantLight(rigOf({formats::DiskLight{.half_angle_deg = 90}}), 10);
  const formats::Image picture = preview(light, 10);
  ASSERT_EQ(picture.width, 512);
  ASSERT_EQ(picture.height, 512);
  EXPECT_EQ(picture.texel(100, 20)[0], 1);   // the upper half of the sphere shines
  EXPECT_EQ(picture.texel(100, 240)[0], 0);  // the lower does not
  EXPECT_NEAR(picture.texel(100, 256 + 60)[0], 1, 0.05);
  EXPECT_NEAR(picture.texel(100, 256 + 196)[0], 0, 0.05);
}

class LightTool : public testing::Test {
 protected:
  int run(const std::string& arguments) const {
    const std::string command = "cd '" + folder_.path().string() + "' && '" + BAKELIGHT_BIN_DIR "/light' " +
                                arguments + " > messages.txt 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
  }
  std::string messages() const { return formats::readTextFile(folder_ / "messages.txt"); }

  tests::TemporaryFolder folder_;
};

TEST_F(LightTool, WritesTensorPreviewAndFigures) {
  formats::writeFileAtomically(folder_ / "rig.json", R"({"lights": [{"type": "sky"}], "windowing": "auto"})");
  ASSERT_EQ(run("--rig rig.json --light l.safetensors --preview l.exr --order 4 --stats s.json"), 0)
      << messages();
  EXPECT_EQ(formats::readSafetensors(folder_ / "l.safetensors").tensors.at("light").shape.at(0), 16u);
  EXPECT_EQ(formats::readImage(folder_ / "l.exr").width, 512);
  const formats::Json stats = formats::readJson(folder_ / "s.json")["stats"];
  EXPECT_EQ(stats["lights"][0]["type"], "sky");
  EXPECT_EQ(stats["lights"][0]["energy_share"], 1);
  EXPECT_GT(stats["moved_energy"].get<double>(), 0);
  EXPECT_GT(stats["window"].get<double>(), 0);
  EXPECT_GE(stats["minimum_luminance_over_mean"].get<double>(), -0.0201);
}

TEST_F(LightTool, SameBytesWithAnyNumberOfThreads) {
  const std::string rig = std::string(BAKELIGHT_SOURCE_DIR) + "/configs/lights/polygons.json";
  for (const std::string threads : {"1", "4"})
    ASSERT_EQ(run("--rig " + rig + " --light " + threads + ".safetensors --preview " + threads +
                  ".exr --threads " + threads),
              0)
        << messages();
  EXPECT_EQ(formats::readFile(folder_ / "1.safetensors"), formats::readFile(folder_ / "4.safetensors"));
  EXPECT_EQ(formats::readFile(folder_ / "1.exr"), formats::readFile(folder_ / "4.exr"));
}

TEST_F(LightTool, PointsIntoABadRig) {
  formats::writeFileAtomically(folder_ / "rig.json", R"({"lights": [{"type": "sky", "turbidty": 3}]})");
  EXPECT_EQ(run("--rig rig.json --light l.safetensors"), 2);
  EXPECT_THAT(messages(), testing::HasSubstr("/lights/0/turbidty"));
  EXPECT_THAT(messages(), testing::HasSubstr("turbidity"));
  EXPECT_EQ(folder_.entryCount(), 2u);  // the rig and the messages
}

TEST_F(LightTool, TellsOfLightThatRingsFarBelowZero) {
  formats::Image sun(64, 32, {"R", "G", "B"});
  for (std::size_t c = 0; c < 3; ++c) sun.texel(20, 8)[c] = 1e5F;
  formats::writeExr(folder_ / "sun.exr", sun, formats::ExrPrecision::kFloat);
  const std::string lights = R"({"lights": [{"type": "environment", "image": "sun.exr"}])";
  formats::writeFileAtomically(folder_ / "rig.json", lights + "}");
  ASSERT_EQ(run("--rig rig.json --light l.safetensors"), 0) << messages();
  EXPECT_THAT(messages(), testing::AllOf(testing::HasSubstr("rings"), testing::HasSubstr("windowing")));

  formats::writeFileAtomically(folder_ / "rig.json", lights + R"(, "windowing": "auto"})");
  ASSERT_EQ(run("--rig rig.json --light l.safetensors"), 0) << messages();
  EXPECT_THAT(messages(), testing::Not(testing::HasSubstr("rings:")));
}

TEST_F(LightTool, DecodesAnEightBitPictureAndSaysSo) {
  const std::string sky = std::string(BAKELIGHT_SOURCE_DIR) + "/tests/cases/hdr/sky_8_bit.png";
  formats::writeFileAtomically(folder_ / "rig.json",
                               R"({"lights": [{"type": "environment", "image": ")" + sky + "\"}]}");
  ASSERT_EQ(run("--rig rig.json --light l.safetensors"), 0) << messages();
  EXPECT_THAT(messages(), testing::HasSubstr("8-bit"));
}

TEST_F(LightTool, WarnsOfARigOfEmittersOnly) {
  formats::writeFileAtomically(folder_ / "rig.json", R"({"emitters": [{"shape": "sphere"}]})");
  EXPECT_EQ(run("--rig rig.json --light l.safetensors"), 0);
  EXPECT_THAT(messages(), testing::HasSubstr("no distant light"));
}

TEST_F(LightTool, WarnsThatPunctualLightsAreNotInTheCoefficients) {
  formats::writeFileAtomically(
      folder_ / "rig.json",
      R"({"lights": [{"type": "disk"}], "punctual": [{"type": "point", "position": [0, 2, 0]}]})");
  EXPECT_EQ(run("--rig rig.json --light l.safetensors"), 0);
  EXPECT_THAT(messages(), testing::HasSubstr("punctual lights have no spherical harmonics"));
}

}  // namespace
}  // namespace bakelight::light
