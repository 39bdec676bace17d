// The driver itself, on a real disk, with small shell scripts for tools.
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/json.h"
#include "pipeline/disk.h"

namespace bakelight::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

struct Ended {
  int status = 0;
  std::string output;  // standard output and error
};

class Driver : public testing::Test {
 protected:
  Driver() {
    std::string name = (fs::temp_directory_path() / "bakelight-driver-XXXXXX").string();
    folder = ::mkdtemp(name.data());
    script("copy", "cat \"$mesh\" > \"$copied\"");
    formats::writeFileAtomically(folder / "recipes/prt.json", std::string_view(R"({
      "asset": {"mesh": {"kind": "mesh", "endings": [".obj"]}},
      "stages": {"copy": {"inputs": {"mesh": "asset.mesh"}, "outputs": {"copied": "{asset}.out"}}},
      "deliver": {"copy": "copy.copied"}})"));
    formats::writeFileAtomically(folder / "cube/cube.obj", std::string_view("v 1 2 3\n"));
  }
  ~Driver() override { fs::remove_all(folder); }

  // A tool with input mesh, output copied and parameter level, whose work is `body`.
  void script(const std::string& name, const std::string& body) {
    const fs::path path = folder / "tools" / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path) << R"(#!/bin/sh
if [ "$1" = --describe ]; then echo '{"tool": "copy", "summary": "", "execution_path": "",
  "inputs": [{"name": "mesh", "kind": "mesh", "required": true}],
  "outputs": [{"name": "copied", "kind": "mesh", "required": true}],
  "parameters": [{"name": "level", "type": "integer", "default": 1, "minimum": 0, "maximum": 9}]}'; exit; fi
while [ $# -gt 0 ]; do case "$1" in
  --mesh) mesh=$2;; --copied) copied=$2;; --stats) stats=$2;; --parameters) parameters=$2;; esac; shift 2; done
)" << body << R"(
status=$?
[ $status = 0 ] || exit $status
echo '{"tool": "copy", "wall_s": 0, "cpu_s": 0, "peak_memory_bytes": 0, "warnings": ["thin"], "stats": {"n": 1}}' > "$stats"
)";
    fs::permissions(path, fs::perms::owner_all);
  }

  std::string command(const std::string& arguments) const {
    return "cd '" + folder.string() + "' && exec '" BAKELIGHT_BIN_DIR "/bakelight' " + arguments +
           " --tools tools --recipes recipes 2>&1";
  }

  Ended run(const std::string& arguments) const {
    Ended ended;
    FILE* pipe = ::popen(command(arguments).c_str(), "r");
    std::array<char, 4096> block;
    for (std::size_t got; (got = ::fread(block.data(), 1, block.size(), pipe)) > 0;)
      ended.output.append(block.data(), got);
    ended.status = WEXITSTATUS(::pclose(pipe));
    return ended;
  }

  std::string read(const std::string& path) const { return formats::readTextFile(folder / path); }
  formats::Json record() const { return formats::readJson(folder / "out/cube/record.json"); }

  bool hasTemporaries() const {
    for (const auto& entry : fs::recursive_directory_iterator(folder / "out"))
      if (entry.path().string().find("tmp-") != std::string::npos) return true;
    return false;
  }

  fs::path folder;
};

TEST_F(Driver, RunsOnceThenIsUpToDate) {
  const Ended first = run("run cube");
  EXPECT_EQ(first.status, 0) << first.output;
  EXPECT_THAT(first.output, HasSubstr("cube copy  ran"));
  EXPECT_THAT(first.output, HasSubstr("(never run)"));
  EXPECT_THAT(first.output, HasSubstr("out/cube/cube.out"));
  EXPECT_EQ(read("out/cube/cube.out"), "v 1 2 3\n");
  EXPECT_EQ(run("run cube").output, "everything is up to date (1 asset, 1 stage)\n");
  EXPECT_EQ(run("explain cube").output, "cube copy: up to date\n");
  EXPECT_EQ(record()["stages"]["copy"]["warnings"][0], "thin");
  EXPECT_GT(record()["stages"]["copy"]["peak_memory_bytes"], 100000);
  EXPECT_EQ(run("explain cube --set copy.level=2").output,
            "cube copy: would run: level changed from 1 to 2\n");
}

TEST_F(Driver, ProgressWarningsAndOtherLines) {
  script("copy", R"(echo '{"progress": {"label": "x", "done": 1, "total": 2, "unit": "u"}}' >&2
echo '{"warning": "two normals missing"}' >&2
printf 'plain words' >&2
cat "$mesh" > "$copied")");
  const Ended ended = run("run cube");
  EXPECT_THAT(ended.output, HasSubstr("cube copy  warning: two normals missing\n"));
  EXPECT_THAT(ended.output, HasSubstr("cube copy  plain words\n"));
  EXPECT_THAT(ended.output, Not(HasSubstr("progress")));
}

TEST_F(Driver, ErrorOfAToolComesThroughWithItsExitStatusAndPublicPaths) {
  script(
      "copy",
      R"(echo '{"error": {"file": "'$copied'", "element": "face 1", "pointer": "", "problem": "is flat", "expected": "", "remedy": "", "paragraph": "", "status": 3}}' >&2
exit 3)");
  const Ended ended = run("run cube");
  EXPECT_EQ(ended.status, 3);
  EXPECT_THAT(ended.output, HasSubstr("bakelight: cube copy: out/cube/cube.out, face 1: is flat."));
  EXPECT_FALSE(hasTemporaries());
}

TEST_F(Driver, KilledToolNamesTheSignal) {
  script("copy", "kill -SEGV $$");
  const Ended ended = run("run cube");
  EXPECT_EQ(ended.status, 128 + SIGSEGV);
  EXPECT_THAT(ended.output, HasSubstr("killed by SIGSEGV"));
}

TEST_F(Driver, InterruptionStopsTheToolRemovesWhatItBeganAndResumes) {
  script("copy", "echo half > \"$copied\"; echo $$ > started; exec sleep 60");
  const pid_t driver = ::fork();
  if (driver == 0) {
    ::execl("/bin/sh", "sh", "-c", (command("run cube") + " > log").c_str(), nullptr);
    ::_exit(127);
  }
  for (int i = 0; i < 500 && !fs::exists(folder / "started"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  ASSERT_TRUE(fs::exists(folder / "started"));
  ::kill(driver, SIGINT);
  int status = 0;
  ::waitpid(driver, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_FALSE(hasTemporaries());
  EXPECT_FALSE(fs::exists(folder / "out/cube/cube.out"));
  EXPECT_EQ(record()["stages"]["copy"]["status"], "not-run");

  script("copy", "cat \"$mesh\" > \"$copied\"");
  EXPECT_EQ(run("run cube").status, 0);
  EXPECT_EQ(read("out/cube/cube.out"), "v 1 2 3\n");
}

TEST_F(Driver, TwoAtOnceDoTheWorkOnce) {
  script("copy", "sleep 0.3; echo x >> count; cat \"$mesh\" > \"$copied\"");
  std::thread other([&] { EXPECT_EQ(run("run cube").status, 0); });
  EXPECT_EQ(run("run cube").status, 0);
  other.join();
  EXPECT_EQ(read("count"), "x\n");
}

TEST_F(Driver, UsageAndInputMistakesBeforeAnythingIsMade) {
  EXPECT_EQ(run("run").status, 1);
  EXPECT_EQ(run("bake cube").status, 1);
  EXPECT_EQ(run("run cube --set nonsense").status, 1);
  EXPECT_EQ(run("run cube --set copy.level=10").status, 1);
  EXPECT_EQ(run("run nowhere").status, 2);
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST_F(Driver, GraphAndToolsAndDryRun) {
  EXPECT_THAT(run("graph cube").output, HasSubstr("\"cube/cube.obj\" -> \"cube copy\" [label=\"mesh\"]"));
  EXPECT_EQ(run("graph cube --format text").output, "cube copy <- cube/cube.obj -> cube.out\n");
  const auto json = formats::Json::parse(run("graph cube --format json").output);
  EXPECT_EQ(json["stages"][0]["parameters"]["level"], 1);
  EXPECT_THAT(run("tools").output, HasSubstr("level = 1"));
  EXPECT_EQ(run("run cube --dry-run").output, "cube copy: would run: never run\n");
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST_F(Driver, MistypedWordsGetASuggestion) {
  for (const auto& [words, meant] :
       std::vector<std::pair<std::string, std::string>>{{"rnu cube", "\"run\""},
                                                        {"run cube --outt o", "\"--out\""},
                                                        {"baseline chek cube", "\"check\""}}) {
    const Ended ended = run(words);
    EXPECT_EQ(ended.status, 1) << words;
    EXPECT_THAT(ended.output, HasSubstr("Try: " + meant)) << words;
  }
}

TEST_F(Driver, NumbersOutOfRangeAreRefusedAsTheyWereWritten) {
  for (const std::string option : {"--threads", "--jobs"})
    for (const std::string value : {"-3", "1e9", "abc", "''", "99999999999999999999"}) {
      const Ended ended = run("run cube " + option + "=" + value);
      EXPECT_EQ(ended.status, 1) << option << " " << value;
      EXPECT_THAT(ended.output, HasSubstr(option)) << value;
      EXPECT_THAT(ended.output, Not(HasSubstr("18446744073709551613")));
    }
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST_F(Driver, RealDiskCopiesAtomicallyAndReportsWhatItCannotWrite) {
  RealDisk disk;
  disk.copy(folder / "cube/cube.obj", folder / "deep/er/copy.obj");
  EXPECT_EQ(read("deep/er/copy.obj"), "v 1 2 3\n");
  EXPECT_THROW(disk.copy(folder / "cube/cube.obj", folder / "cube/cube.obj/below"), Error);
  EXPECT_THROW(disk.write("/proc/nothing", "x"), Error);
  EXPECT_EQ(disk.list(folder / "deep/er"), std::vector<std::string>{"copy.obj"});
}

}  // namespace
}  // namespace bakelight::pipeline
