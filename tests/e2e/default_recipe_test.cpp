// What a user does: run the driver on the default asset, look at the picture, change something, make
// mistakes.
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "formats/file.h"
#include "formats/json.h"
#include "formats/mesh_import.h"
#include "formats/pack.h"
#include "tests/e2e/example_outliers.h"
#include "tests/e2e/player_comparison.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

namespace bakelight::tests {
namespace {

namespace fs = std::filesystem;
using formats::Json;

const fs::path kBin = BAKELIGHT_BIN_DIR;
const fs::path kSource = BAKELIGHT_SOURCE_DIR;
const fs::path kData = kBin.parent_path() / "assets";
const fs::path kBunny = kSource / "configs/assets/bunny";

// Of the surface's mean radiance. A vertex in a fold, by its point alone, makes a black spot of 0.6 on the
// bunny; what normals that differ from vertex to vertex make is 0.25, on 6,000 triangles 0.4.
constexpr double kSpot = 0.5;

using Outcome = ShellOutcome;

// The words, joined by spaces, as a shell sees them.
Outcome shell(const std::vector<std::string>& words) {
  std::string command;
  for (const auto& word : words) command.append(word).append(" ");
  return tests::shell(command);
}

std::string quoted(const fs::path& path) {
  return std::string("'").append(path.string()).append("'");
}

class Driver {
 public:
  explicit Driver(fs::path out) : out_(std::move(out)) {}

  Outcome run(const fs::path& asset, const std::string& options = "") const {
    return call("run", asset, options);
  }
  Outcome explain(const fs::path& asset, const std::string& options = "") const {
    return call("explain", asset, options);
  }
  // Stage → status, as the record says.
  Json statuses(const std::string& asset) const {
    Json result = Json::object();
    const Json record = formats::readJson(out_ / asset / "record.json");
    for (const auto& [stage, entry] : record.at("stages").items()) result[stage] = entry.at("status");
    return result;
  }
  const fs::path& out() const { return out_; }

 private:
  Outcome call(const std::string& command, const fs::path& asset, const std::string& options) const {
    return shell({quoted(kBin / "bakelight"), command, quoted(asset), "--out", quoted(out_), "--data",
                  quoted(kData), options});
  }
  fs::path out_;
};

// One bake serves all tests of the suite.
class DefaultRecipe : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    driver_ = std::make_unique<Driver>(*folder_ / "out");
    first_run_ = driver_->run(kBunny);
  }
  static void TearDownTestSuite() {
    driver_.reset();
    folder_.reset();
  }
  void SetUp() override { ASSERT_EQ(first_run_.status, 0) << first_run_.output; }

  static inline std::unique_ptr<TemporaryFolder> folder_;
  static inline std::unique_ptr<Driver> driver_;
  static inline Outcome first_run_;
};

TEST_F(DefaultRecipe, DeliversTheBunny) {
  EXPECT_THAT(first_run_.output, testing::HasSubstr("frame.png"));
  const formats::Pack pack = formats::readPack(driver_->out() / "bunny/bunny.glb");
  EXPECT_EQ(pack.name, "bunny");
  EXPECT_EQ(pack.sh().order, 5);
  EXPECT_EQ(pack.sh().transport, formats::Transport::kInterreflected);
  EXPECT_NEAR(static_cast<double>(pack.mesh.vertexCount()), 10800, 200);
  EXPECT_TRUE(pack.neighborhood) << "it stands on no ground";
  // An ordinary glTF reader sees the same triangles.
  EXPECT_EQ(formats::importMesh(driver_->out() / "bunny/bunny.glb").mesh.triangleCount(),
            pack.mesh.triangleCount());
}

TEST_F(DefaultRecipe, NoVertexShowsAsASpot) {
  const LitOutlier found = worstLitOutlier(driver_->out() / "bunny", kData / "probes");
  EXPECT_LT(found.worst.excess, kSpot) << found.text();
  std::printf("%s\n", found.text().c_str());
}

TEST_F(DefaultRecipe, PixelsAreThoseOfTheCpu) {
  const double window =
      formats::readJson(driver_->out() / "bunny/window/stats.json").at("stats").at("lambda").get<double>();
  const auto result =
      comparePlayerWithCpu(kBin / "player", driver_->out() / "bunny/bunny.glb",
                           {.environment_path = kData / "probes/sunrise.exr", .windowing = window}, {},
                           *folder_ / "pictures", {.ground_albedo = formats::Float3{0.5F, 0.5F, 0.5F}});
  EXPECT_TRUE(result.agrees()) << result.summary();
  std::printf("%s\n", result.summary().c_str());
  // The picture that was compared is the one that was delivered.
  EXPECT_TRUE(formats::readTextFile(driver_->out() / "bunny/frame.png") ==
              formats::readTextFile(*folder_ / "pictures/player.png"));
}

TEST_F(DefaultRecipe, SecondRunAndTouchDoNothing) {
  const Outcome second = driver_->run(kBunny);
  EXPECT_EQ(second.status, 0);
  EXPECT_THAT(second.output, testing::HasSubstr("up to date"));
  ASSERT_EQ(shell({"touch", quoted(kData / "models/bunny.obj"), quoted(kBunny / "asset.json")}).status, 0);
  EXPECT_THAT(driver_->run(kBunny).output, testing::HasSubstr("up to date"));
  EXPECT_EQ(driver_->statuses("bunny"), Json({{"simplify", "cached"},
                                              {"survey", "cached"},
                                              {"transfer", "cached"},
                                              {"neighborhood", "cached"},
                                              {"pack", "cached"},
                                              {"frame_truth", "cached"},
                                              {"window", "cached"},
                                              {"frame", "cached"}}));
}

TEST_F(DefaultRecipe, ChangedOrderRunsTransferAndLaterOnly) {
  const Driver driver(*folder_ / "order");
  ASSERT_EQ(driver.run(kBunny).status, 0);
  const Outcome explained = driver.explain(kBunny, "--set transfer.order=4");
  EXPECT_THAT(explained.output, testing::HasSubstr("order changed from 5 to 4"));
  ASSERT_EQ(driver.run(kBunny, "--set transfer.order=4").status, 0);
  EXPECT_EQ(driver.statuses("bunny"), Json({{"simplify", "cached"},
                                            {"survey", "cached"},
                                            {"transfer", "ran"},
                                            {"neighborhood", "ran"},
                                            {"pack", "ran"},
                                            {"frame_truth", "cached"},
                                            {"window", "ran"},
                                            {"frame", "ran"}}));
  EXPECT_EQ(formats::readPack(driver.out() / "bunny/bunny.glb").sh().order, 4);
  // Back to what was there before: from the cache.
  ASSERT_EQ(driver.run(kBunny).status, 0);
  EXPECT_EQ(driver.statuses("bunny")["transfer"], "cached");
  EXPECT_EQ(formats::readPack(driver.out() / "bunny/bunny.glb").sh().order, 5);
}

TEST_F(DefaultRecipe, SameBytesWithOneThread) {
  const Driver driver(*folder_ / "one");
  ASSERT_EQ(driver.run(kBunny, "--threads 1 -j 1").status, 0);
  for (const char* file : {"bunny.glb", "frame.png", "simplify/mesh.ply", "transfer/transfer.safetensors"})
    EXPECT_EQ(formats::readTextFile(driver.out() / "bunny" / file),
              formats::readTextFile(driver_->out() / "bunny" / file))
        << file;
}

TEST_F(DefaultRecipe, StageThatNothingDeliversIsLeftOut) {
  const Driver driver(*folder_ / "pack-only");
  ASSERT_EQ(driver.run(kBunny, "--deliver pack --set transfer.directions=64").status, 0);
  EXPECT_EQ(driver.statuses("bunny")["frame"], "left-out");
  EXPECT_TRUE(fs::exists(driver.out() / "bunny/bunny.glb"));
  EXPECT_FALSE(fs::exists(driver.out() / "bunny/frame.png"));
}

// The other assets that come with the project, baked coarsely: through the driver to the player's pixels.
class ReadyAsset : public testing::Test {
 protected:
  PlayerComparison runAndCompare(const std::string& asset, const PlayerLights& lights) {
    const Driver driver(folder_ / "out");
    const Outcome outcome = driver.run(kSource / "configs/assets" / asset,
                                       "--set simplify.triangles=6000 --set transfer.directions=256");
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    const auto result = comparePlayerWithCpu(kBin / "player", driver.out() / asset / (asset + ".glb"), lights,
                                             {}, folder_ / "pictures");
    EXPECT_TRUE(result.agrees()) << result.summary();
    const LitOutlier found = worstLitOutlier(driver.out() / asset, kData / "probes");
    EXPECT_LT(found.worst.excess, kSpot) << found.text();
    return result;
  }

  TemporaryFolder folder_;
};

TEST_F(ReadyAsset, LampsNearTheBunny) {
  const auto result = runAndCompare("near_bunny", {.rig_path = kSource / "configs/lights/near.json"});
  EXPECT_GT(result.emitter_pixels, 1000u);
}

TEST_F(ReadyAsset, GlossyBunny) {
  const auto result = runAndCompare("glossy_bunny", {.environment_path = kData / "probes/sunrise.exr"});
  EXPECT_EQ(result.allowed_difference, 2) << "the pack is not glossy";
}

// Mistakes: one paragraph each that names the file and the place, the documented status, and nothing
// half-written.
class BadInput : public testing::Test {
 protected:
  void expectError(const Outcome& outcome, int status, const std::vector<std::string>& parts) {
    EXPECT_EQ(outcome.status, status) << outcome.output;
    for (const auto& part : parts) EXPECT_THAT(outcome.output, testing::HasSubstr(part));
  }
  void expectNoDeliverable(const std::string& asset) {
    EXPECT_FALSE(fs::exists(driver_.out() / asset / (asset + ".glb")));
    EXPECT_FALSE(fs::exists(driver_.out() / asset / "frame.png"));
    if (!fs::exists(driver_.out())) return;
    for (const auto& entry : fs::recursive_directory_iterator(driver_.out()))
      EXPECT_EQ(entry.path().filename().string().find("tmp-"), std::string::npos) << entry.path();
  }
  fs::path assetWith(const std::string& json) {
    formats::writeFileAtomically(folder_ / "thing/asset.json", json);
    if (!fs::exists(folder_ / "thing/bunny.obj"))
      fs::create_symlink(kData / "models/bunny.obj", folder_ / "thing/bunny.obj");
    return folder_ / "thing";
  }

  TemporaryFolder folder_;
  Driver driver_{folder_ / "out"};
};

TEST_F(BadInput, TruncatedObj) {
  const std::string whole = formats::readTextFile(kData / "models/bunny.obj");
  // Cut within a vertex line, and after the vertices but within the faces' last line.
  for (const std::size_t size : {std::size_t{100'010}, whole.size() - 6}) {
    formats::writeFileAtomically(folder_ / "cut/cut.obj", whole.substr(0, size));
    expectError(driver_.run(folder_ / "cut"), 2, {"cut.obj", "Expected"});
    expectNoDeliverable("cut");
  }
}

TEST_F(BadInput, EmptyFolder) {
  fs::create_directories(folder_ / "empty");
  expectError(driver_.run(folder_ / "empty"), 2, {"empty"});
  expectNoDeliverable("empty");
}

TEST_F(BadInput, UnknownKey) {
  expectError(driver_.run(assetWith(R"({"mesh": "bunny.obj", "stages": {"transfer": {"ordr": 5}}})")), 2,
              {"asset.json", "/stages/transfer/ordr", "order"});
  expectError(driver_.run(assetWith(R"({"mesh": "bunny.obj", "enviroment": "a.exr"})")), 2,
              {"asset.json", "/enviroment", "environment"});
  expectNoDeliverable("thing");
}

TEST_F(BadInput, OrderOf99) {
  expectError(driver_.run(assetWith(R"({"mesh": "bunny.obj", "stages": {"transfer": {"order": 99}}})")), 2,
              {"asset.json", "/stages/transfer/order", "from 1 to 10"});
  expectError(driver_.run(assetWith(R"({"mesh": "bunny.obj"})"), "--set transfer.order=99"), 1,
              {"transfer.order", "from 1 to 10"});
  expectNoDeliverable("thing");
}

TEST_F(BadInput, MissingProbe) {
  expectError(driver_.run(assetWith(R"({"mesh": "bunny.obj", "environment": "nowhere.exr"})")), 2,
              {"asset.json", "/environment", "nowhere.exr"});
  expectNoDeliverable("thing");
}

// A limit on file sizes fails writes as a full disk does.
TEST_F(BadInput, FullDisk) {
  const fs::path asset = assetWith(R"({"mesh": "bunny.obj"})");
  const Outcome outcome = shell({"(ulimit -f 200; trap '' XFSZ; exec", quoted(kBin / "bakelight"), "run",
                                 quoted(asset), "--out", quoted(driver_.out()), ")"});
  expectError(outcome, 4, {"mesh.ply"});
  expectNoDeliverable("thing");
  // With room again, the same command goes through.
  EXPECT_EQ(driver_.run(folder_ / "thing", "--deliver pack --set transfer.directions=64").status, 0);
}

}  // namespace
}  // namespace bakelight::tests
