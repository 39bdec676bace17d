// What a user does with the recipe translucent: a ball of marble, down to its picture; and what goes wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "formats/image.h"
#include "formats/json.h"
#include "formats/pack.h"
#include "formats/translucency.h"
#include "tests/support/shapes.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

namespace bakelight::tests {
namespace {

namespace fs = std::filesystem;
using formats::Json;

const std::string kBin = BAKELIGHT_BIN_DIR;

class TranslucentRecipe : public testing::Test {
 protected:
  void SetUp() override {
    asset_ = folder_ / "ball";
    fs::create_directories(asset_);
    std::ofstream obj(asset_ / "ball.obj");
    const TriangleMesh ball = icosphere(2);
    for (const Float3& p : ball.positions) obj << "v " << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
    for (const auto& t : ball.triangles)
      obj << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
    // A sky as bright everywhere.
    formats::Image sky(16, 8, {"R", "G", "B"});
    std::fill(sky.values.begin(), sky.values.end(), 1.0F);
    formats::writeExr(asset_ / "sky.exr", sky);
  }
  ShellOutcome bake(const Json& material) {
    const Json json = {
        {"mesh", "ball.obj"},
        {"environment", "sky.exr"},
        {"recipe", "translucent"},
        {"material", material},
        {"stages",
         {{"simplify", {{"triangles", 1500}}},
          {"atlas", {{"resolution", 128}}},
          {"transfer", {{"directions", 512}}},
          {"frame",
           {{"width", 160}, {"height", 120}, {"background", "transparent"}, {"auto_exposure", false}}}}}};
    std::ofstream(asset_ / "asset.json") << json;
    return shell(kBin + "/bakelight run '" + asset_.string() + "' --out '" + (folder_ / "out").string() +
                 "'");
  }
  fs::path out(const std::string& name) const { return folder_ / "out/ball" / name; }

  TemporaryFolder folder_;
  fs::path asset_;
};

// Two units across, a centimetre a unit: much larger than the mean free path, so nearly as a plane.
TEST_F(TranslucentRecipe, BakesABall) {
  const ShellOutcome outcome = bake({{"medium", {{"name", "marble"}, {"unit_mm", 20}}}});
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const formats::Pack pack = formats::readPack(out("ball.glb"));
  const auto* translucency = pack.appearances.front().reflection.as<formats::Translucency>();
  ASSERT_NE(translucency, nullptr);
  EXPECT_GT(translucency->knot_count, 700);  // 1,500 triangles of what had 320
  EXPECT_NEAR(translucency->fallback.thickness, 4.0F / 3, 0.03F);
  EXPECT_GT(translucency->fallback.reflectance[0], translucency->fallback.reflectance[2]);
  const formats::Image frame = formats::readImage(out("frame.png"));
  // Even light gives an even ball, lighter in red than in blue.
  const float* middle = frame.texel(80, 60);
  EXPECT_GT(middle[0], middle[2] + 0.01F);
  EXPECT_GT(middle[2], 0.5F);
  std::size_t compared = 0;
  for (int y = 45; y < 75; ++y)
    for (int x = 65; x < 95; ++x, ++compared)
      EXPECT_NEAR(frame.texel(x, y)[0], middle[0], 0.03F) << x << ' ' << y;
  EXPECT_EQ(compared, 900U);
}

TEST_F(TranslucentRecipe, SaysWhatIsMissing) {
  const ShellOutcome opaque = bake({{"albedo", {0.8, 0.8, 0.8}}});
  EXPECT_NE(opaque.status, 0);
  EXPECT_THAT(opaque.output, testing::HasSubstr("no medium"));

  ASSERT_EQ(bake({{"medium", {{"name", "marble"}, {"unit_mm", 20}}}}).status, 0);
  const auto file = [&](const std::string& name) {
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / "out"))
      if (entry.path().filename() == name) return "'" + entry.path().string() + "'";
    return std::string("missing");
  };
  // Transfer of all that falls on the surface would make the object too bright.
  const std::string plain = "'" + (folder_ / "plain.safetensors").string() + "'";
  ASSERT_EQ(shell(kBin + "/transfer " + file("atlas.ply") + " --directions 64 --transfer " + plain).status,
            0);
  const ShellOutcome packed =
      shell(kBin + "/pack " + file("atlas.ply") + " --transfer " + plain + " --kernels " +
            file("kernels.safetensors") + " --pack '" + (folder_ / "no.glb").string() + "'");
  EXPECT_EQ(packed.status, 2);
  EXPECT_THAT(packed.output, testing::HasSubstr("all that falls on the surface"));
  EXPECT_FALSE(fs::exists(folder_ / "no.glb"));
}

}  // namespace
}  // namespace bakelight::tests
