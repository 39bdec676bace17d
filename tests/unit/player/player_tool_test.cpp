// The executable itself: files in, files out, exit status.
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/image.h"
#include "formats/json.h"
#include "tests/e2e/made_packs.h"

namespace bakelight {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  int status;
  std::string messages;
};

class PlayerTool : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::temp_directory_path() /
        ("bakelight-player-" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::create_directories(folder_);
    formats::writePack(folder_ / "sphere.glb", tests::spherePack(3, 16), {});
  }
  void TearDown() override { fs::remove_all(folder_); }

  Outcome play(const std::string& arguments) const {
    const std::string command = "cd '" + folder_.string() + "' && '" + BAKELIGHT_BIN_DIR "/player' " +
                                arguments + " > messages.txt 2>&1";
    const int status = std::system(command.c_str());
    return {WEXITSTATUS(status), formats::readTextFile(folder_ / "messages.txt")};
  }

  fs::path folder_;
};

TEST_F(PlayerTool, WritesAPictureAndItsFigures) {
  const Outcome outcome =
      play("--pack sphere.glb --image frame.png --width 80 --height 60 --stats stats.json");
  ASSERT_EQ(outcome.status, 0) << outcome.messages;
  const formats::Image picture = formats::readImage(folder_ / "frame.png");
  EXPECT_EQ(picture.width, 80);
  EXPECT_EQ(picture.height, 60);
  const formats::Json stats = formats::readJson(folder_ / "stats.json")["stats"];
  EXPECT_EQ(stats["vertices"], 17 * 32);
  EXPECT_EQ(stats["order"], 3);
  EXPECT_GT(stats["exposure"].get<double>(), 0);
  EXPECT_GT(stats["frame_ms"].get<double>(), 0);
  EXPECT_GT(stats["light_change_ms"].get<double>(), 0);
  EXPECT_GT(stats["read_back_ms"].get<double>(), 0);
  EXPECT_GT(stats["gpu_frame_ms"].get<double>(), 0);
  EXPECT_GE(stats["gpu_light_change_ms"].get<double>(), 0);
  EXPECT_EQ(stats["technique"], "vertices");
  std::vector<std::string> passes;
  for (const auto& [name, pass_ms] : stats["gpu_pass_ms"].items()) {
    passes.push_back(name);
    EXPECT_GE(pass_ms.get<double>(), 0) << name;
  }
  EXPECT_THAT(passes, testing::UnorderedElementsAre("diffuse", "surface", "backdrop", "resolve"));
}

// A player is small: no importer, no ray tracer, and no reader of pictures of every kind.
TEST_F(PlayerTool, LoadsFewLibraries) {
  const std::string command =
      "ldd '" BAKELIGHT_BIN_DIR "/player' > '" + (folder_ / "libraries.txt").string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::string libraries = formats::readTextFile(folder_ / "libraries.txt");
  for (const char* heavy : {"OpenImageIO", "assimp", "embree"})
    EXPECT_EQ(libraries.find(heavy), std::string::npos) << heavy;
  const auto lines = std::count(libraries.begin(), libraries.end(), '\n');
  EXPECT_GT(lines, 5);
  EXPECT_LE(lines, 45);
}

TEST_F(PlayerTool, ExrHoldsLinearRadianceWhateverTheExposure) {
  ASSERT_EQ(play("--pack sphere.glb --image a.exr --width 20 --height 20").status, 0);
  ASSERT_EQ(play("--pack sphere.glb --image b.exr --width 20 --height 20 --exposure-ev 4").status, 0);
  const formats::Image picture = formats::readImage(folder_ / "a.exr");
  EXPECT_EQ(picture.channelCount(), 4u);
  EXPECT_GE(picture.channelIndex("A"), 0);
  EXPECT_EQ(formats::readFile(folder_ / "a.exr"), formats::readFile(folder_ / "b.exr"));
}

TEST_F(PlayerTool, SameBytesWithOneThreadAndMany) {
  ASSERT_EQ(play("--pack sphere.glb --image a.png --width 64 --height 64 --threads 1").status, 0);
  ASSERT_EQ(play("--pack sphere.glb --image b.png --width 64 --height 64 --threads 4").status, 0);
  EXPECT_EQ(formats::readFile(folder_ / "a.png"), formats::readFile(folder_ / "b.png"));
}

TEST_F(PlayerTool, OrderOneAndTenInOnePixel) {
  for (const int order : {1, 10}) {
    formats::writePack(folder_ / "ball.glb", tests::spherePack(order, 8), {});
    const Outcome outcome = play("--pack ball.glb --image dot.png --width 1 --height 1");
    EXPECT_EQ(outcome.status, 0) << outcome.messages;
    EXPECT_EQ(formats::readImage(folder_ / "dot.png").width, 1);
  }
}

TEST_F(PlayerTool, UnknownEndingIsAUsageErrorBeforeAnyWork) {
  const Outcome outcome = play("--pack missing.glb --image frame.jpg");
  EXPECT_EQ(outcome.status, static_cast<int>(ExitStatus::kUsage));
  EXPECT_THAT(outcome.messages, testing::HasSubstr("frame.jpg"));
}

TEST_F(PlayerTool, TruncatedPackIsBadInput) {
  formats::Bytes bytes = formats::readFile(folder_ / "sphere.glb");
  bytes.resize(bytes.size() / 2);
  formats::writeFileAtomically(folder_ / "half.glb", bytes);
  const Outcome outcome = play("--pack half.glb --image frame.png");
  EXPECT_EQ(outcome.status, static_cast<int>(ExitStatus::kBadInput));
  EXPECT_THAT(outcome.messages, testing::HasSubstr("half.glb"));
  EXPECT_FALSE(fs::exists(folder_ / "frame.png"));
}

TEST_F(PlayerTool, EnvironmentThatIsNoProbeIsBadInput) {
  formats::writeExr(folder_ / "square.exr", formats::Image(8, 8, {"R", "G", "B"}));
  const Outcome outcome = play("--pack sphere.glb --environment square.exr --image frame.png");
  EXPECT_EQ(outcome.status, static_cast<int>(ExitStatus::kBadInput));
  EXPECT_THAT(outcome.messages, testing::HasSubstr("square.exr"));
}

TEST_F(PlayerTool, RigAndEnvironmentAddUpAndSayWhatTheWindowTook) {
  const auto write = [&](const std::string& name, const std::string& json) {
    formats::writeFileAtomically(folder_ / name, json);
  };
  formats::Image sky(32, 16, {"R", "G", "B"});
  std::ranges::fill(sky.values, 0.25F);
  formats::writeExr(folder_ / "sky.exr", sky, formats::ExrPrecision::kFloat);
  write("disk.json", R"({"lights": [{"type": "disk", "half_angle_deg": 20, "radiance": [2, 2, 2]}]})");
  write("both.json", R"({"lights": [{"type": "disk", "half_angle_deg": 20, "radiance": [2, 2, 2]},
                                    {"type": "environment", "image": "sky.exr"}]})");
  const std::string frame = "--pack sphere.glb --width 64 --height 64 --background black ";
  ASSERT_EQ(play(frame + "--lights both.json --image a.png").status, 0);
  ASSERT_EQ(play(frame + "--lights disk.json --environment sky.exr --image b.png").status, 0);
  EXPECT_EQ(formats::readFile(folder_ / "a.png"), formats::readFile(folder_ / "b.png"));

  ASSERT_EQ(play(frame + "--lights disk.json --windowing 0.02 --image c.png --stats stats.json").status, 0);
  const formats::Json stats = formats::readJson(folder_ / "stats.json")["stats"];
  EXPECT_EQ(stats["window"], 0.02);
  EXPECT_GT(stats["moved_energy"].get<double>(), 0);
  write("windowed.json", R"({"lights": [{"type": "disk", "half_angle_deg": 20}], "windowing": 0.02})");
  for (const auto& [words, window] : std::vector<std::pair<std::string, double>>{
           {"", 0.02}, {" --windowing rig", 0.02}, {" --windowing none", 0}, {" --windowing 0", 0}}) {
    ASSERT_EQ(play(frame + "--lights windowed.json --image d.png --stats d.json" + words).status, 0) << words;
    EXPECT_EQ(formats::readJson(folder_ / "d.json")["stats"]["window"], window) << words;
  }
  EXPECT_EQ(stats["storage"], "none");
  EXPECT_EQ(stats["precision"], "float32");
  EXPECT_FALSE(stats.contains("cube_ms"));
}

TEST_F(PlayerTool, EmittersMoveWithTime) {
  formats::writeFileAtomically(folder_ / "near.json",
                               R"({"emitters": [{"shape": "sphere", "position": [2, 0, 0], "radius": 0.4,
                                   "motion": {"kind": "orbit", "axis": [0, 1, 0], "period_s": 4}}]})");
  const std::string frame = "--pack sphere.glb --lights near.json --width 64 --height 64 ";
  ASSERT_EQ(play(frame + "--image start.png --stats stats.json").status, 0);
  const formats::Json stats = formats::readJson(folder_ / "stats.json")["stats"];
  EXPECT_GT(stats["cube_ms"].get<double>(), 0);
  EXPECT_GT(stats["gpu_cube_ms"].get<double>(), 0);
  for (const char* pass : {"cube map", "cube map projection", "emitters"})
    EXPECT_TRUE(stats["gpu_pass_ms"].contains(pass)) << pass;
  ASSERT_EQ(play(frame + "--time-s 1 --image later.png").status, 0);
  ASSERT_EQ(play(frame + "--time-s 4 --image period.png").status, 0);
  EXPECT_NE(formats::readFile(folder_ / "start.png"), formats::readFile(folder_ / "later.png"));
  EXPECT_EQ(formats::readFile(folder_ / "start.png"), formats::readFile(folder_ / "period.png"));
}

TEST_F(PlayerTool, BadRigIsBadInputThatNamesThePlace) {
  formats::writeFileAtomically(folder_ / "dark.json", R"({"lights": []})");
  formats::writeFileAtomically(folder_ / "typo.json", R"({"emitters": [{"shape": "sphere", "radus": 1}]})");
  for (const auto& [file, word] : {std::pair{"dark.json", "light"}, {"typo.json", "/emitters/0/radus"}}) {
    const Outcome outcome = play(std::string("--pack sphere.glb --image frame.png --lights ") + file);
    EXPECT_EQ(outcome.status, static_cast<int>(ExitStatus::kBadInput)) << outcome.messages;
    EXPECT_THAT(outcome.messages, testing::AllOf(testing::HasSubstr(file), testing::HasSubstr(word)));
    EXPECT_FALSE(fs::exists(folder_ / "frame.png"));
  }
}

TEST_F(PlayerTool, NoDisplayIsSaidWithTheWayRound) {
  ASSERT_EQ(::unsetenv("DISPLAY"), 0);
  const Outcome outcome = play("--pack sphere.glb");
  EXPECT_EQ(outcome.status, static_cast<int>(ExitStatus::kNotAvailable)) << outcome.messages;
  EXPECT_THAT(outcome.messages, testing::HasSubstr("--image"));
}

}  // namespace
}  // namespace bakelight
