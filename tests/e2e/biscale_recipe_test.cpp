// What a user does with the recipe biscale: a patch laid out over a mesh, down to the id map, and shaded from a pack; a mesh whose texture
// coordinates are the index themselves; materials with patches of their own.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "formats/btf_reflection.h"
#include "formats/btf_writer.h"
#include "formats/image.h"
#include "formats/index_image.h"
#include "formats/json.h"
#include "formats/meso_mesh.h"
#include "formats/pack.h"
#include "formats/radiance_transfer_texture.h"
#include "formats/rtt_reflection.h"
#include "tests/support/exemplars.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tube.h"

namespace bakelight::tests {
namespace {

namespace fs = std::filesystem;
using formats::Json;

const std::string kBin = BAKELIGHT_BIN_DIR;

class BiscaleRecipe : public testing::Test {
 protected:
  ShellOutcome bake(Uv uv, const std::string& options = "", const Json& patch = {{"file", "stones.exr"}},
                    const std::string& recipe = "biscale",
                    const Json& transfer = {{"directions", 512}, {"clusters", 4}}) {
    const fs::path asset = folder_ / "tube";
    fs::create_directories(asset);
    writeTube(asset / "tube.obj", uv);
    formats::writeExr(asset / "stones.exr", stones(32, 12));
    const Json json = {{"mesh", "tube.obj"},
                       {"recipe", recipe},
                       {"material", {{"patch", patch}}},
                       {"stages",
                        {{"simplify", {{"triangles", 384}}},
                         {"atlas", {{"resolution", 256}}},
                         {"mesomesh", {{"vertices", 8000}}},
                         {"rtt", {{"resolution", 16}, {"views", 3}}},
                         {"transfer", transfer},
                         {"frame", {{"width", 160}, {"height", 120}}}}}};
    std::ofstream(asset / "asset.json") << json;
    return shell(kBin + "/bakelight run '" + asset.string() + "' --out '" + (folder_ / "out").string() +
                 "' " + options);
  }
  fs::path out(const std::string& name) const { return folder_ / "out/tube" / name; }
  Json record() const { return formats::readJson(out("record.json")); }

  TemporaryFolder folder_;
};

TEST_F(BiscaleRecipe, LaysThePatchOutAndMapsIt) {
  const ShellOutcome outcome = bake(Uv::kNone);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const formats::MesoMesh meso = formats::readMesoMesh(out("meso.ply"));
  EXPECT_NEAR(static_cast<double>(meso.mesh.vertexCount()), 8000, 400);
  EXPECT_EQ(meso.mesh.colors.size(), meso.mesh.vertexCount());
  const formats::Pack pack = formats::readPack(out("tube.glb"));
  const auto* rtt = pack.appearances.front().reflection.as<formats::RttReflection>();
  ASSERT_NE(rtt, nullptr);
  EXPECT_EQ(rtt->width, 16);
  ASSERT_TRUE(rtt->index);
  EXPECT_EQ(rtt->index->width, 256);
  EXPECT_EQ(formats::readImage(out("frame.png")).width, 160);
  // The width that texels have for synthesis, found again in the meso-mesh's places.
  const Json figures = record().at("stages").at("mesomesh").at("stats");
  EXPECT_NEAR(rtt->patch_width, 32 * figures.at("patches")[0].at("texel_size").get<double>(),
              0.1 * rtt->patch_width);
  EXPECT_GT(figures.at("coverage"), 0.8);
  EXPECT_GT(figures.at("coherent_share"), 0.4);

  // Every covered texel shows the place of its vertex, which is near.
  const std::vector<std::string> channels = {"patch.U", "patch.V", "vertex", "coverage"};
  const formats::IndexImage ids = formats::readIndexExr(out("id_map.exr"), channels);
  ASSERT_EQ(ids.width, 256);
  const formats::Image maps = formats::readImage(out("maps.exr"));
  const auto position = static_cast<std::size_t>(maps.channelIndex("position.X"));
  std::size_t covered = 0;
  for (int y = 0; y < ids.height; ++y)
    for (int x = 0; x < ids.width; ++x) {
      const std::uint32_t* id = ids.texel(x, y);
      if (id[3] == 0) continue;
      ++covered;
      EXPECT_NEAR(id[0], meso.patch[id[2]][0] * 65536, 0.5);
      EXPECT_NEAR(id[1], meso.patch[id[2]][1] * 65536, 0.5);
      double squared = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        const double way = meso.mesh.positions[id[2]][c] - maps.texel(x, y)[position + c];
        squared += way * way;
      }
      EXPECT_LT(squared, 0.1 * 0.1) << x << ' ' << y;  // edges are about 0.06
    }
  EXPECT_GT(covered, 20000u);
  for (const char* picture :
       {"id_map.png", "id_map_on_model.png", "texture.png", "directions.png", "coherence.png"})
    EXPECT_EQ(formats::readImage(out(picture)).width, 1024) << picture;
}

TEST_F(BiscaleRecipe, TextureCoordinatesThatAreAnAtlasAreTheIndex) {
  const ShellOutcome outcome = bake(Uv::kUnrolled);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const Json stages = record().at("stages");
  for (const char* stage : {"mesomesh", "idmap"}) {
    EXPECT_EQ(stages.at(stage).at("status"), "left-out") << stage;
    ASSERT_EQ(stages.at(stage).at("left_out").size(), 1u) << stage;
    EXPECT_EQ(stages.at(stage).at("left_out")[0].at("figure"), "own_uv.shortcomings");
    EXPECT_EQ(stages.at(stage).at("left_out")[0].at("value"), 0);
  }
  EXPECT_EQ(stages.at("btf").at("status"), "left-out");
  EXPECT_FALSE(fs::exists(out("id_map.exr")));
  EXPECT_TRUE(fs::exists(out("atlas.ply")));
  const ShellOutcome kept = bake(Uv::kUnrolled, "--keep-all");
  ASSERT_EQ(kept.status, 0) << kept.output;
  EXPECT_TRUE(fs::exists(out("id_map.exr")));
}

// 24 directions of views and lights, four columns of texels bright and four dark.
formats::BtfInfo sampling() {
  formats::BtfInfo info;
  info.width = info.height = 8;
  for (int i = 0; i < 24; ++i) info.lights.push_back({(i / 8) * 0.6 + 0.1, (i % 8) * 0.7853981634});
  info.views = info.lights;
  return info;
}

void writeMeasured(const fs::path& path, double view_share) {
  const formats::BtfInfo info = sampling();
  std::vector<float> values;
  for (const formats::BtfDirection& view : info.views)
    for (const formats::BtfDirection& light : info.lights)
      for (int texel = 0; texel < 64; ++texel)
        for (int c = 0; c < 3; ++c)
          values.push_back(
              static_cast<float>(std::cos(light.polar_rad) * (0.15 + 0.1 * ((texel % 8) < 4)) *
                                 (1 + view_share * std::sin(view.polar_rad) * std::cos(view.azimuth_rad))));
  formats::writeRawBtf(path, *formats::btfOf(info, std::move(values)));
}

// The driver has btf project it and rtt take it over; texels, views and values are the measured ones.
TEST_F(BiscaleRecipe, MeasuredBtfOfAPatchIsProjectedAndPacked) {
  fs::create_directories(folder_ / "tube");
  writeMeasured(folder_ / "tube/felt.btf", 0.8);
  const Json patch = {{"btf", {{"file", "felt.btf"}}}};
  const ShellOutcome outcome = bake(Uv::kUnrolled, "", patch);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const formats::Pack pack = formats::readPack(out("tube.glb"));
  const auto* rtt = pack.appearances.front().reflection.as<formats::RttReflection>();
  ASSERT_NE(rtt, nullptr);
  EXPECT_EQ(rtt->width, 8);
  EXPECT_EQ(rtt->views, 8);
  const auto textures = formats::readRadianceTransferTextures(out("rtt.exr"));
  ASSERT_EQ(textures.size(), 1U);
  // Under a uniform sky: π × the reflectance per steradian, of the bright and the dark half.
  const double sky = 3.5449077;
  double left = 0, right = 0;
  for (int row = 0; row < 8; ++row)
    for (int column = 0; column < 8; ++column) {
      left += sky * textures[0].response(column, row, 1, 4)[0] / 64;
      right += sky * textures[0].response(column, row, 6, 4)[0] / 64;
    }
  EXPECT_NEAR(left, 3.14159 * 0.25, 0.02);
  EXPECT_NEAR(right, 3.14159 * 0.15, 0.02);
  EXPECT_EQ(record().at("stages").at("btf").at("status"), "ran");

  // Only what hangs on it is made again, and a patch that looks alike from everywhere has one view.
  writeMeasured(folder_ / "tube/felt.btf", 0);
  const ShellOutcome again = bake(Uv::kUnrolled, "", patch);
  ASSERT_EQ(again.status, 0) << again.output;
  EXPECT_EQ(record().at("stages").at("simplify").at("status"), "cached");
  EXPECT_EQ(record().at("stages").at("btf").at("status"), "ran");
  EXPECT_EQ(formats::readRadianceTransferTextures(out("rtt.exr")).front().views, 1);
}

// A file as measured ones are, 81 × 81 directions of their own and factorised, becomes the BTF of a pack in a pixel basis.
TEST_F(BiscaleRecipe, MeasuredBtfIsResampledForLightOfAllFrequencies) {
  formats::BtfInfo info;
  info.width = info.height = 4;
  info.views = {{0, 0}};
  for (const auto& [polar_deg, around] : {std::pair(15, 6), {30, 12}, {45, 18}, {60, 20}, {75, 24}})
    for (int a = 0; a < around; ++a) info.views.push_back({polar_deg * 0.0174533, a * 6.2831853 / around});
  ASSERT_EQ(info.views.size(), 81U);
  info.lights = info.views;
  // Of full rank: each of the texels has a lobe of its own.
  std::vector<formats::BtfFactors> channels(3);
  for (formats::BtfFactors& factors : channels) {
    factors.rank = 16;
    factors.singular_values.assign(16, 1);
    factors.texels.assign(16 * 16, 0);
    for (std::size_t k = 0; k < 16; ++k) factors.texels[k * 17] = 1;
    for (const formats::BtfDirection& view : info.views)
      for (const formats::BtfDirection& light : info.lights)
        for (int k = 0; k < 16; ++k)
          factors.directions.push_back(static_cast<float>(
              std::cos(light.polar_rad) * (0.1 + 0.01 * k +
                                           0.05 * std::sin(light.polar_rad) * std::sin(view.polar_rad) *
                                               std::cos(light.azimuth_rad - view.azimuth_rad - k))));
  }
  fs::create_directories(folder_ / "tube");
  formats::writeFactorizedBtf(folder_ / "tube/ubo.btf", info, formats::BtfColorModel::kRgb, channels,
                              formats::BtfPrecision::kHalf);
  const ShellOutcome outcome =
      bake(Uv::kUnrolled, "", {{"btf", {{"file", "ubo.btf"}}}}, "allfreq", {{"cube_side", 4}});
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const formats::Pack pack = formats::readPack(out("tube.glb"));
  const auto* btf = pack.appearances.front().reflection.as<formats::BtfReflection>();
  ASSERT_NE(btf, nullptr);
  EXPECT_EQ(btf->width, 4);
  EXPECT_EQ(btf->lights, 8);
  EXPECT_EQ(btf->views, 8);
  EXPECT_LT(btf->error, 0.08);
  // Light of the same radiance from everywhere: about π × the mean of texel 6's reflectance per steradian.
  const std::vector<float> factors = btf->factors.decode();
  const auto components = static_cast<std::size_t>(btf->components);
  double sky = 0;
  for (std::size_t k = 0; k < components; ++k)
    for (std::size_t cell = 0; cell < 64; ++cell)
      sky +=
          factors[(6 * 64 + 27) * components + k] * btf->basisOf(static_cast<int>(k))[cell] * 6.2831853 / 64;
  EXPECT_NEAR(sky, 3.14159 * 0.16, 0.05);
}

// A surface without a picture is laid out by how it looks (mesomesh --rtt); frames of the meso-mesh and the width that it has there reach
// the pack.
TEST_F(BiscaleRecipe, SurfaceWithoutAPictureIsLaidOutByItsTransfer) {
  const std::string dents = BAKELIGHT_SOURCE_DIR "/configs/patches/dents.png";
  const ShellOutcome outcome = bake(Uv::kNone, "", {{"width", 0.5}, {"height", {{"file", dents}}}});
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const Json stages = record().at("stages");
  const std::string exemplar = stages.at("mesomesh").at("stats").at("patches")[0].at("file");
  EXPECT_NE(exemplar.find("transfer texture"), std::string::npos) << exemplar;
  EXPECT_EQ(stages.at("idmap").at("status"), "ran");
  EXPECT_EQ(stages.at("idmap").at("stats").at("undetermined_frames"), 0);
  const formats::Pack pack = formats::readPack(out("tube.glb"));
  const auto* rtt = pack.appearances.front().reflection.as<formats::RttReflection>();
  ASSERT_NE(rtt, nullptr);
  ASSERT_TRUE(rtt->index);
  EXPECT_NEAR(rtt->patch_width, 0.5, 0.05);
  // Tangents of the pack are those that the id map wrote for each vertex, not those of the atlas's texture coordinates.
  const formats::MesoMesh meso = formats::readMesoMesh(out("meso.ply"));
  const std::vector<formats::Float4>& tangents = pack.sh().glossy->tangents;
  std::size_t along = 0;
  for (std::size_t v = 0; v < tangents.size(); ++v) {
    std::size_t nearest = 0;
    double least = 1e30;
    for (std::size_t m = 0; m < meso.mesh.vertexCount(); ++m) {
      double squared = 0;
      for (std::size_t c = 0; c < 3; ++c)
        squared += std::pow(meso.mesh.positions[m][c] - pack.mesh.positions[v][c], 2);
      if (squared < least) least = squared, nearest = m;
    }
    double cosine = 0;
    for (std::size_t c = 0; c < 3; ++c) cosine += meso.tangents[nearest][c] * tangents[v][c];
    along += cosine > 0.9;
  }
  EXPECT_GT(static_cast<double>(along), 0.9 * static_cast<double>(tangents.size()));
}

TEST_F(BiscaleRecipe, SaysWhatIsWrongWithAPatch) {
  const ShellOutcome missing = bake(Uv::kNone, "", {{"file", "wool.exr"}});
  EXPECT_EQ(missing.status, 2);
  EXPECT_NE(missing.output.find("/material/patch/file"), std::string::npos) << missing.output;
  const ShellOutcome bare = bake(
      Uv::kNone, "",
      {{"file", "stones.exr"}, {"height", {{"file", "stones.exr"}}}, {"texture", {{"file", "paint.png"}}}});
  EXPECT_EQ(bare.status, 2);
  EXPECT_NE(bare.output.find("paint.png"), std::string::npos) << bare.output;
  EXPECT_NE(bare.output.find("/material/patch/texture/file"), std::string::npos) << bare.output;
  std::ofstream(folder_ / "tube/felt.btf") << "!DFMF08FCR";
  const ShellOutcome cut = bake(Uv::kNone, "", {{"btf", {{"file", "felt.btf"}}}});
  EXPECT_EQ(cut.status, 2);
  EXPECT_NE(cut.output.find("felt.btf"), std::string::npos) << cut.output;
  const ShellOutcome huge = bake(Uv::kNone, "", {{"file", "stones.exr"}, {"width", 1e-5}});
  EXPECT_EQ(huge.status, 2);
  EXPECT_NE(huge.output.find("stones.exr"), std::string::npos) << huge.output;
}

}  // namespace
}  // namespace bakelight::tests
