// scripts/corpus over a small folder: what it finds, whatever the names, and what it takes for a failure.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "formats/json.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

namespace bakelight::tests {
namespace {

namespace fs = std::filesystem;
using formats::Json;

const fs::path kBin = BAKELIGHT_BIN_DIR;
const fs::path kScript = fs::path(BAKELIGHT_SOURCE_DIR) / "scripts/corpus";

void write(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path) << text;
}

std::string quoted(const fs::path& path) {
  return std::string("'").append(path.string()).append("'");
}

const char* const kTetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

class Corpus : public testing::Test {
 protected:
  ShellOutcome run(const fs::path& bin, const std::string& options = "") {
    std::string command = quoted(kScript);
    command.append(" ").append(quoted(meshes())).append(" --json ").append(quoted(folder_ / "table.json"));
    return shell(command.append(" --bin ").append(quoted(bin)).append(" ").append(options));
  }
  fs::path meshes() const { return folder_ / "meshes"; }
  // Mesh → what became of it.
  std::map<std::string, std::string> statuses() const {
    std::map<std::string, std::string> found;
    const Json table = formats::readJson(folder_ / "table.json");
    for (const Json& result : table.at("results")) found[result.at("mesh")] = result.at("status");
    return found;
  }
  // A folder of tools whose driver is a script.
  fs::path fakeDriver(const std::string& script) {
    const fs::path bin = folder_ / "bin";
    write(bin / "bakelight", std::string("#!/bin/sh\n").append(script).append("\n"));
    fs::permissions(bin / "bakelight", fs::perms::owner_exec, fs::perm_options::add);
    return bin;
  }

  TemporaryFolder folder_;
};

TEST_F(Corpus, FindsMeshesByAnyNameAndTellsRefusedOnes) {
  write(meshes() / "in a folder/it's \"odd\" & ü.OBJ", kTetrahedron);
  write(meshes() / "cut.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n");
  write(meshes() / "read.me", "not a mesh");
  const ShellOutcome outcome = run(kBin, "--limit 500");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_EQ(statuses(), (std::map<std::string, std::string>{{"in a folder/it's \"odd\" & ü.OBJ", "ok"},
                                                            {"cut.obj", "refused"}}));
  EXPECT_THAT(outcome.output, testing::HasSubstr("prt    2 meshes: 1 ok, 1 refused, 0 failed"));
  EXPECT_THAT(outcome.output, testing::HasSubstr("atlas  2 meshes: 1 ok, 1 refused, 0 failed"));
}

TEST_F(Corpus, EverythingElseIsAFailure) {
  write(meshes() / "a.obj", kTetrahedron);
  const std::map<std::string, std::string> kinds = {
      {"kill -SEGV $$", "exit status -11"},
      {"echo 'bakelight: a.obj: tool was killed by signal 11'; exit 139", "exit status 139"},
      {"exit 2", "exit status 2"},
      {"echo 'bakelight: internal error: vector index is too large'; exit 2", "internal error"},
      {"exec sleep 60", "took more than 1 s"},
      {"exit 0", "no record.json"}};
  for (const auto& [script, reason] : kinds) {
    const ShellOutcome outcome = run(fakeDriver(script), "--chains prt --limit 1");
    EXPECT_EQ(outcome.status, 1) << script;
    EXPECT_EQ(statuses().at("a.obj"), "failed") << script;
    EXPECT_THAT(outcome.output, testing::HasSubstr(reason)) << script;
  }
}

TEST_F(Corpus, AFolderWithoutMeshesIsAMistake) {
  write(meshes() / "read.me", "not a mesh");
  EXPECT_EQ(run(kBin).status, 2);
}

}  // namespace
}  // namespace bakelight::tests
