// What a user does with the recipe atlas: meshes without texture coordinates, with good ones and with bad
// ones; cuts; a texture that is dilated.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "formats/image.h"
#include "formats/json.h"
#include "formats/mesh_ply.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tube.h"

namespace bakelight::tests {
namespace {

namespace fs = std::filesystem;
using formats::Json;

const std::string kBin = BAKELIGHT_BIN_DIR;

class AtlasRecipe : public testing::Test {
 protected:
  // Runs the driver on a tube with the recipe atlas; `more` is added to asset.json.
  ShellOutcome bake(Uv uv, const Json& more = Json::object()) {
    const fs::path asset = folder_ / "tube";
    fs::create_directories(asset);
    writeTube(asset / "tube.obj", uv);
    Json json = {{"mesh", "tube.obj"}, {"recipe", "atlas"}, {"stages", {{"atlas", {{"resolution", 256}}}}}};
    json.update(more);
    std::ofstream(asset / "asset.json") << json;
    return shell(kBin + "/bakelight run '" + asset.string() + "' --out '" + (folder_ / "out").string() + "'");
  }
  fs::path out(const std::string& name) const { return folder_ / "out/tube" / name; }
  Json stage(const std::string& name) const {
    return formats::readJson(out("record.json")).at("stages").at(name);
  }

  TemporaryFolder folder_;
};

TEST_F(AtlasRecipe, MakesAnAtlasMapsAndPictures) {
  const ShellOutcome outcome = bake(Uv::kNone);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const Json stats = stage("atlas").at("stats");
  EXPECT_EQ(stats.at("flipped"), 0);
  EXPECT_EQ(stats.at("overlapping_texels"), 0);
  EXPECT_GE(stats.at("smallest_gutter"), 2);
  EXPECT_TRUE(stage("atlas").value("left_out", Json::array()).empty());
  const formats::TriangleMesh mesh = formats::readPly(out("atlas.ply"));
  EXPECT_EQ(mesh.triangleCount(), 2u * kAround * kAlong);
  EXPECT_EQ(mesh.texcoords.size(), mesh.vertexCount());
  // The texels' areas are the tube's.
  const formats::Image maps = formats::readImage(out("maps.exr"));
  ASSERT_EQ(maps.width, 256);
  const auto area = static_cast<std::size_t>(maps.channelIndex("area"));
  double sum = 0;
  for (std::size_t i = area; i < maps.values.size(); i += maps.channelCount()) sum += maps.values[i];
  const double tube = kAround * 2 * std::sin(std::numbers::pi / kAround) * 0.5 * kAlong;
  EXPECT_NEAR(sum, tube, 1e-4 * tube);
  for (const char* picture : {"charts.png", "stretch.png", "model.png"})
    EXPECT_EQ(formats::readImage(out(picture)).width, 1024) << picture;
}

TEST_F(AtlasRecipe, KeepsTextureCoordinatesThatAreAnAtlas) {
  const ShellOutcome outcome = bake(Uv::kUnrolled);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  // Left out, with the figure that showed it.
  const Json left_out = stage("atlas").at("left_out");
  ASSERT_EQ(left_out.size(), 1u);
  EXPECT_EQ(left_out[0].at("figure"), "own_uv.shortcomings");
  EXPECT_EQ(left_out[0].at("value"), 0);
  EXPECT_EQ(stage("atlas").at("stats").at("charts"), 1);
  const formats::TriangleMesh mesh = formats::readPly(out("atlas.ply"));
  for (const formats::Float2& t : mesh.texcoords) EXPECT_LE(t[0], 0.9701f);
  EXPECT_EQ(mesh.vertexCount(), (kAround + 1u) * (kAlong + 1u));
}

TEST_F(AtlasRecipe, ReplacesTextureCoordinatesThatOverlap) {
  const ShellOutcome outcome = bake(Uv::kOverlapping);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_GT(stage("own_uv").at("stats").at("shortcomings"), 0);
  EXPECT_TRUE(stage("atlas").value("left_out", Json::array()).empty());
  EXPECT_EQ(stage("atlas").at("stats").at("overlapping_texels"), 0);
  // Whoever insists is told what is wrong.
  const ShellOutcome insisted = bake(Uv::kOverlapping, {{"stages", {{"atlas", {{"texcoords", "own"}}}}}});
  EXPECT_EQ(insisted.status, 2);
  EXPECT_NE(insisted.output.find("no valid atlas"), std::string::npos) << insisted.output;
}

TEST_F(AtlasRecipe, CutsAlongLinesOfTheAsset) {
  fs::create_directories(folder_ / "tube");
  std::ofstream(folder_ / "tube/cuts.json") << R"({"cuts": [[[1, 0, 0], [1, 0, 4]]]})";
  const ShellOutcome outcome =
      bake(Uv::kNone,
           {{"cuts", "cuts.json"}, {"stages", {{"atlas", {{"segmentation", "cuts"}, {"resolution", 256}}}}}});
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_EQ(stage("atlas").at("stats").at("cut_edges"), kAlong);
  EXPECT_EQ(stage("atlas").at("stats").at("charts"), 1);
  EXPECT_NEAR(stage("atlas").at("stats").at("l2_stretch").get<double>(), 1, 1e-3);
}

TEST_F(AtlasRecipe, DilatesATextureIntoTheGutter) {
  const ShellOutcome outcome = bake(Uv::kNone);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const ShellOutcome dilated =
      shell(kBin + "/dilate --image '" + out("maps.exr").string() + "' --maps '" + out("maps.exr").string() +
            "' --dilated '" + (folder_ / "dilated.exr").string() + "'");
  ASSERT_EQ(dilated.status, 0) << dilated.output;
  const formats::Image image = formats::readImage(folder_ / "dilated.exr");
  const auto chart = static_cast<std::size_t>(image.channelIndex("chart"));
  for (std::size_t i = chart; i < image.values.size(); i += image.channelCount())
    ASSERT_GE(image.values[i], 0);
}

TEST_F(AtlasRecipe, SaysWhereACutIsWrong) {
  fs::create_directories(folder_ / "tube");
  std::ofstream(folder_ / "tube/cuts.json") << R"({"cuts": [[0, 99999]]})";
  const ShellOutcome outcome = bake(Uv::kNone, {{"cuts", "cuts.json"}});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.output.find("cuts.json, at /cuts/0/1"), std::string::npos) << outcome.output;
}

}  // namespace
}  // namespace bakelight::tests
