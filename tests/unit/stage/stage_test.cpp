#include "tools/stage/stage.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/stage_record.h"
#include "tests/support/temporary_folder.h"

namespace bakelight::stage {
namespace {

namespace fs = std::filesystem;
using formats::Json;
using tests::TemporaryFolder;

enum class Mode { kShadowed, kUnshadowed };
constexpr formats::Word<Mode> kModes[] = {{"shadowed", Mode::kShadowed}, {"unshadowed", Mode::kUnshadowed}};

// A tool with one of everything, run in this process.
struct Sample {
  fs::path mesh, table;
  bool draco = false;
  int order = 5;
  double bias = 0.5;
  formats::Float3 albedo = {0.8f, 0.8f, 0.8f};
  Mode mode = Mode::kShadowed;
  int runs = 0;
  std::function<void(stage::Run&)> body = [](stage::Run&) {};
  std::string out, err;

  void declare(Tool& tool) {
    tool.input("mesh", "mesh", mesh, "the mesh")
        .output("table_file", "tensors", table, "the table", false)
        .parameter("draco", draco, "compress")
        .parameter("order", order, {1, 10}, "bands", "how fine")
        .parameter("bias", bias, {0, 1}, "", "how far")
        .parameter("albedo", albedo, {0, 1}, "", "how bright")
        .parameter("mode", mode, kModes, "which");
  }

  int run(std::vector<std::string> words) {
    words.insert(words.begin(), "sample");
    std::vector<char*> argv;
    for (auto& word : words) argv.push_back(word.data());
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    Tool tool("sample", "A tool for the test.");
    declare(tool);
    const int status = tool.run(static_cast<int>(argv.size()), argv.data(), [&](stage::Run& run) {
      ++runs;
      body(run);
    });
    out = testing::internal::GetCapturedStdout();
    err = testing::internal::GetCapturedStderr();
    return status;
  }
};

TEST(Tool, CommandLineFillsEverything) {
  Sample sample;
  EXPECT_EQ(sample.run({"--mesh", "a.ply", "--table-file", "b", "--draco", "true", "--order", "7", "--bias",
                        "0.25", "--albedo", "0", "0.5", "1", "--mode", "unshadowed"}),
            0)
      << sample.err;
  EXPECT_EQ(sample.runs, 1);
  EXPECT_EQ(sample.mesh, "a.ply");
  EXPECT_EQ(sample.table, "b");
  EXPECT_TRUE(sample.draco);
  EXPECT_EQ(sample.order, 7);
  EXPECT_EQ(sample.bias, 0.25);
  EXPECT_EQ(sample.albedo, (formats::Float3{0, 0.5f, 1}));
  EXPECT_EQ(sample.mode, Mode::kUnshadowed);
}

TEST(Tool, DefaultsStayAndFlagAloneMeansTrue) {
  Sample sample;
  EXPECT_EQ(sample.run({"--mesh", "a.ply", "--draco"}), 0) << sample.err;
  EXPECT_TRUE(sample.draco);
  EXPECT_EQ(sample.order, 5);
}

TEST(Tool, FirstInputMayStandAlone) {
  Sample sample;
  EXPECT_EQ(sample.run({"a.ply", "--order", "2"}), 0) << sample.err;
  EXPECT_EQ(sample.mesh, "a.ply");
}

TEST(Tool, CommandLineWinsOverParameterFile) {
  const TemporaryFolder folder;
  formats::writeFileAtomically(folder / "p.json", R"({"order": 3, "mode": "unshadowed"})");
  Sample sample;
  EXPECT_EQ(sample.run({"--mesh", "a", "--parameters", (folder / "p.json").string(), "--order", "4"}), 0)
      << sample.err;
  EXPECT_EQ(sample.order, 4);
  EXPECT_EQ(sample.mode, Mode::kUnshadowed);
}

TEST(Tool, DescribesItself) {
  Sample sample;
  EXPECT_EQ(sample.run({"--describe"}), 0);
  const auto description = formats::toolDescriptionFromJson(Json::parse(sample.out), "sample");
  EXPECT_EQ(description.tool, "sample");
  ASSERT_NE(description.findParameter("order"), nullptr);
  EXPECT_EQ(description.findParameter("order")->default_value, 5);
  EXPECT_EQ(description.findParameter("order")->maximum, 10);
  EXPECT_EQ(description.findParameter("albedo")->default_value.dump(), "[0.8,0.8,0.8]");
  EXPECT_THAT(description.findParameter("mode")->choices, testing::ElementsAre("shadowed", "unshadowed"));
  EXPECT_EQ(description.findParameter("mode")->default_value, "shadowed");
  EXPECT_TRUE(description.findInput("mesh")->required);
  EXPECT_FALSE(description.findOutput("table_file")->required);
  EXPECT_EQ(sample.runs, 0);
}

TEST(Tool, HelpNamesParametersWithRangeAndDefault) {
  Sample sample;
  EXPECT_EQ(sample.run({"--help"}), 0);
  EXPECT_THAT(sample.out, testing::HasSubstr("--order"));
  EXPECT_THAT(sample.out, testing::HasSubstr("from 1 to 10"));
  EXPECT_THAT(sample.out, testing::HasSubstr("default 5"));
}

TEST(Tool, UsageErrorsGiveStatusOneAndOneParagraph) {
  const std::vector<std::vector<std::string>> wrong = {{"--mesh", "a", "--ordr", "5"},
                                                       {},
                                                       {"--mesh", "a", "--order", "99"},
                                                       {"--mesh", "a", "--order", "five"},
                                                       {"--mesh", "a", "--albedo", "1", "2", "3"},
                                                       {"--mesh", "a", "--mode", "unshadwed"}};
  for (const auto& words : wrong) {
    Sample sample;
    EXPECT_EQ(sample.run(words), 1);
    EXPECT_EQ(sample.runs, 0);
    EXPECT_EQ(std::count(sample.err.begin(), sample.err.end(), '\n'), 1) << sample.err;
    EXPECT_THAT(sample.err, testing::StartsWith("sample: "));
  }
}

TEST(Tool, ParameterFileErrorsGiveStatusTwoWithPointer) {
  const TemporaryFolder folder;
  formats::writeFileAtomically(folder / "p.json", R"({"order": 99})");
  Sample sample;
  EXPECT_EQ(sample.run({"--mesh", "a", "--parameters", (folder / "p.json").string()}), 2);
  EXPECT_THAT(sample.err, testing::HasSubstr("p.json, at /order: 99 is out of range"));
}

TEST(Tool, ErrorsOfTheBodyBecomeTheExitStatus) {
  for (const ExitStatus status :
       {ExitStatus::kBadInput, ExitStatus::kNotAvailable, ExitStatus::kCannotWrite}) {
    Sample sample;
    sample.body = [&](stage::Run&) {
      throw Error(status, {"f", "face 3", ""}, "is wrong", "right", "mend it");
    };
    EXPECT_EQ(sample.run({"--mesh", "a"}), static_cast<int>(status));
    EXPECT_EQ(sample.err, "sample: f, face 3: is wrong. Expected: right. Try: mend it.\n");
  }
  Sample sample;
  sample.body = [](stage::Run&) { throw std::bad_alloc(); };
  EXPECT_EQ(sample.run({"--mesh", "a"}), 3);
}

TEST(Tool, JsonStyleReportsErrorsAndWarningsAsJson) {
  Sample sample;
  sample.body = [](stage::Run& run) {
    run.warn("thin ice");
    throw badInput({"f", "", "/a"}, "is wrong");
  };
  EXPECT_EQ(sample.run({"--mesh", "a", "--progress", "json"}), 2);
  const auto newline = sample.err.find('\n');
  EXPECT_EQ(Json::parse(sample.err.substr(0, newline))["warning"], "thin ice");
  const Json error = Json::parse(sample.err.substr(newline + 1))["error"];
  EXPECT_EQ(error["pointer"], "/a");
  EXPECT_EQ(error["status"], 2);
}

TEST(Tool, WritesStats) {
  const TemporaryFolder folder;
  Sample sample;
  sample.body = [](stage::Run& run) {
    run.stat("rays", 42);
    run.warn("thin ice");
  };
  EXPECT_EQ(sample.run({"--mesh", "a", "--stats", (folder / "stats.json").string()}), 0);
  const auto record = formats::stageRecordFromJson(formats::readJson(folder / "stats.json"), "stats.json");
  EXPECT_EQ(record.tool, "sample");
  EXPECT_EQ(record.stats["rays"], 42);
  EXPECT_EQ(record.warnings, std::vector<std::string>{"thin ice"});
  EXPECT_GT(record.peak_memory_bytes, 1000000u);
}

TEST(Tool, ThreadsLimitTheWorkers) {
  Sample sample;
  std::size_t limit = 0;
  sample.body = [&](stage::Run& run) {
    EXPECT_EQ(run.threads(), 1);
    limit = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  };
  EXPECT_EQ(sample.run({"--mesh", "a", "--threads", "1"}), 0);
  EXPECT_EQ(limit, 1u);
}

}  // namespace
}  // namespace bakelight::stage
