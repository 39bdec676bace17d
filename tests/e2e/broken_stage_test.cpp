// Mistakes that a stage's code could have, put there on purpose: `bakelight baseline check` names the stage.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "formats/mesh_ply.h"
#include "tests/e2e/broken_tools.h"
#include "tests/support/shapes.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

namespace bakelight::tests {
namespace {

namespace fs = std::filesystem;
using testing::ContainsRegex;
using testing::HasSubstr;

const fs::path kBin = BAKELIGHT_BIN_DIR;
const fs::path kBrokenStage = kBin.parent_path() / "tests/broken_stage";

// Two bodies that shade and light each other, in no symmetric position.
TriangleMesh bodies() {
  TriangleMesh mesh = icosphere(2);
  append(mesh, icosphere(2, 0.6, {1.2, 0.9, 0.4}));
  return mesh;
}

class BrokenStage : public testing::Test {
 protected:
  void bakeAndSave(const std::string& recipe) {
    formats::writePly(asset_ / "bodies.ply", bodies());
    std::ofstream(asset_ / "asset.json")
        << R"({ "mesh": "bodies.ply", "deliver": ["pack"], "recipe": ")" << recipe << "\" }";
    const ShellOutcome saved = baseline("save", kBin);
    ASSERT_EQ(saved.status, 0) << saved.output;
  }

  ShellOutcome baseline(const std::string& action, const fs::path& tools) {
    std::string command;
    for (const std::string& word :
         {(kBin / "bakelight").string(), std::string("baseline"), action, asset_.string(),
          std::string("--out"), (folder_ / "out").string(), std::string("--tools"), tools.string()})
      command.append("'").append(word).append("' ");
    return shell(command);
  }

  ShellOutcome checkWithBroken(const std::string& kind) {
    const fs::path tools = folder_ / kind;
    makeBrokenTools(tools, kBin, kBrokenStage, kind);
    return baseline("check", tools);
  }

  void expectCaught(const std::string& kind) {
    const ShellOutcome checked = checkWithBroken(kind);
    EXPECT_EQ(checked.status, 1) << checked.output;
    EXPECT_THAT(checked.output, ContainsRegex("transfer +transfer +tensors +tensor [^\n]*DIFFERS\n"));
    EXPECT_THAT(checked.output, ContainsRegex("pack +pack +pack +[^\n]*DIFFERS\n"));  // made from it
    EXPECT_THAT(checked.output, ContainsRegex("simplify +simplified +mesh +bytes +equal +ok\n"));
  }

  void expectGoodToolsPass() {
    const ShellOutcome checked = baseline("check", kBin);
    EXPECT_EQ(checked.status, 0) << checked.output;
    EXPECT_THAT(checked.output, HasSubstr("outputs are as in the baseline"));
    EXPECT_THAT(checked.output, testing::Not(HasSubstr("DIFFERS")));
  }

  TemporaryFolder folder_;
  const fs::path asset_ = folder_ / "bodies";
};

TEST_F(BrokenStage, OfDiffuseTransferIsCaught) {
  ASSERT_NO_FATAL_FAILURE(bakeAndSave("prt"));
  expectGoodToolsPass();
  for (const char* kind : {"dropped_pi", "flipped_axis", "turned_vectors"}) {
    SCOPED_TRACE(kind);
    expectCaught(kind);
  }
  expectGoodToolsPass();
}

TEST_F(BrokenStage, OfGlossyTransferIsCaught) {
  ASSERT_NO_FATAL_FAILURE(bakeAndSave("glossy"));
  expectGoodToolsPass();
  for (const char* kind : {"turned_frames", "flipped_axis"}) {
    SCOPED_TRACE(kind);
    expectCaught(kind);
  }
}

// It is the break that is caught, not the detour: a wrapper that spoils nothing passes.
TEST_F(BrokenStage, WrappedToolThatIsNotBrokenPasses) {
  ASSERT_NO_FATAL_FAILURE(bakeAndSave("prt"));
  const fs::path tools = folder_ / "whole";
  makeBrokenTools(tools, kBin, "/usr/bin/env", "--");
  const ShellOutcome checked = baseline("check", tools);
  EXPECT_EQ(checked.status, 0) << checked.output;
}

TEST_F(BrokenStage, MissingBaselineIsBadInput) {
  ASSERT_NO_FATAL_FAILURE(bakeAndSave("prt"));
  fs::remove(asset_ / "baseline/baseline.json");
  const ShellOutcome checked = baseline("check", kBin);
  EXPECT_EQ(checked.status, 2) << checked.output;
  EXPECT_THAT(checked.output, HasSubstr("is no baseline"));
}

}  // namespace
}  // namespace bakelight::tests
