// What a user does with the recipe biscale: a patch laid out over a mesh, down to the id map, and shaded from a pack; a mesh whose texture
// coordinates are the index themselves; materials with patches of their own.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "formats/image.h"
#include "formats/index_image.h"
#include "formats/json.h"
#include "formats/meso_mesh.h"
#include "formats/pack.h"
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
  ShellOutcome bake(Uv uv, const std::string& options = "", const Json& patch = {{"file", "stones.exr"}}) {
    const fs::path asset = folder_ / "tube";
    fs::create_directories(asset);
    writeTube(asset / "tube.obj", uv);
    formats::writeExr(asset / "stones.exr", stones(32, 12));
    const Json json = {{"mesh", "tube.obj"},
                       {"recipe", "biscale"},
                       {"material", {{"patch", patch}}},
                       {"stages",
                        {{"simplify", {{"triangles", 384}}},
                         {"atlas", {{"resolution", 256}}},
                         {"mesomesh", {{"vertices", 8000}}},
                         {"rtt", {{"resolution", 16}, {"views", 3}}},
                         {"transfer", {{"directions", 512}, {"clusters", 4}}},
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
  EXPECT_FALSE(fs::exists(out("id_map.exr")));
  EXPECT_TRUE(fs::exists(out("atlas.ply")));
  const ShellOutcome kept = bake(Uv::kUnrolled, "--keep-all");
  ASSERT_EQ(kept.status, 0) << kept.output;
  EXPECT_TRUE(fs::exists(out("id_map.exr")));
}

TEST_F(BiscaleRecipe, SaysWhatIsWrongWithAPatch) {
  const ShellOutcome missing = bake(Uv::kNone, "", {{"file", "wool.exr"}});
  EXPECT_EQ(missing.status, 2);
  EXPECT_NE(missing.output.find("/material/patch/file"), std::string::npos) << missing.output;
  const ShellOutcome huge = bake(Uv::kNone, "", {{"file", "stones.exr"}, {"width", 1e-5}});
  EXPECT_EQ(huge.status, 2);
  EXPECT_NE(huge.output.find("stones.exr"), std::string::npos) << huge.output;
}

}  // namespace
}  // namespace bakelight::tests
