// The scheduler and the cache together, in memory: what runs, what does not, and what is left behind.
#include "pipeline/build.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>

#include "formats/error.h"
#include "workshop.h"

namespace bakelight::pipeline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

using Tools = std::vector<std::string>;

TEST(Build, MakesDeliverablesAndIntermediates) {
  Workshop workshop;
  EXPECT_EQ(workshop.run().exitStatus(), 0);
  EXPECT_EQ(workshop.toolsStarted(), (Tools{"simplify", "transfer", "pack", "player"}));
  EXPECT_EQ(workshop.disk.read("out/cube/simplify/mesh.ply"), "eight corners at 100");
  EXPECT_EQ(workshop.disk.read("out/cube/transfer/transfer.safetensors"), "eight corners at 100 order 5");
  EXPECT_EQ(workshop.disk.read("out/cube/cube.glb"),
            "\"cube\"eight corners at 100eight corners at 100 order 5");
  EXPECT_THAT(workshop.disk.read("out/cube/frame.png"), HasSubstr("under blue"));
}

TEST(Build, SecondRunStartsNothingAndWritesNothingAfterItsRecord) {
  Workshop workshop;
  workshop.run();
  workshop.toolsStarted();
  workshop.run();  // the record changes once, from "ran" to "cached"
  workshop.disk.writes = workshop.disk.hashes = 0;
  const BuildResult result = workshop.run();
  EXPECT_THAT(workshop.toolsStarted(), IsEmpty());
  EXPECT_EQ(workshop.disk.writes, 0);
  EXPECT_EQ(workshop.disk.hashes, 0);
  for (const Outcome& outcome : result.outcomes) {
    EXPECT_EQ(outcome.status, StageStatus::kCached);
    EXPECT_FALSE(outcome.published);
  }
  EXPECT_EQ(workshop.runner.descriptions, 4);  // of the first run; remembered since
}

TEST(Build, TouchedInputIsHashedAgainAndNothingElseHappens) {
  Workshop workshop;
  workshop.run();
  workshop.run();
  workshop.toolsStarted();
  workshop.disk.touch("assets/cube/cube.obj");
  workshop.disk.hashes = 0;
  workshop.run();
  EXPECT_THAT(workshop.toolsStarted(), IsEmpty());
  EXPECT_EQ(workshop.disk.hashes, 1);
}

TEST(Build, ParameterReRunsItsStageAndWhatComesAfter) {
  Workshop workshop;
  workshop.run();
  workshop.toolsStarted();
  workshop.options.settings = {parseSetting("transfer.order=4")};
  const BuildResult result = workshop.run();
  EXPECT_EQ(workshop.toolsStarted(), (Tools{"transfer", "pack", "player"}));
  EXPECT_EQ(result.outcomes[1].reason, "order changed from 5 to 4");
  EXPECT_EQ(workshop.record()["stages"]["simplify"]["status"], "cached");
  EXPECT_EQ(workshop.record()["stages"]["transfer"]["status"], "ran");
}

TEST(Build, SwitchingAParameterBackComesFromTheCache) {
  Workshop workshop;
  workshop.run();
  workshop.options.settings = {parseSetting("transfer.order=4")};
  workshop.run();
  workshop.toolsStarted();
  workshop.options.settings.clear();
  const BuildResult result = workshop.run();
  EXPECT_THAT(workshop.toolsStarted(), IsEmpty());
  EXPECT_EQ(result.outcomes[1].reason, "order changed from 4 to 5");
  EXPECT_EQ(workshop.disk.read("out/cube/transfer/transfer.safetensors"), "eight corners at 100 order 5");
}

TEST(Build, UnchangedOutputStopsTheRebuild) {
  Workshop workshop;
  workshop.run();
  workshop.toolsStarted();
  workshop.disk.write("assets/cube/cube.obj", "EIGHT corners");
  workshop.run();
  EXPECT_EQ(workshop.toolsStarted(), (Tools{"simplify"}));
}

TEST(Build, BufferOfAGltfBelongsToItsContent) {
  Workshop workshop;
  workshop.disk.write(
      "box/box.gltf",
      R"({"buffers": [{"uri": "box.bin"}, {"uri": "data:,"}], "images": [{"uri": "wood.png"}]})");
  workshop.disk.write("box/box.bin", "1");
  workshop.run({"box"});
  workshop.toolsStarted();
  workshop.run({"box"});
  EXPECT_THAT(workshop.toolsStarted(), IsEmpty());
  for (const std::string companion : {"box/box.bin", "box/wood.png"}) {
    workshop.disk.write(companion, "2");
    workshop.run({"box"});
    EXPECT_EQ(workshop.toolsStarted(), (Tools{"simplify"}))
        << companion;  // the fake one looks at the .gltf only
  }
}

TEST(Build, RebuiltToolRunsAgain) {
  Workshop workshop;
  workshop.run();
  workshop.toolsStarted();
  workshop.disk.write("tools/pack", "2");
  const BuildResult result = workshop.run();
  EXPECT_EQ(workshop.toolsStarted(), (Tools{"pack"}));  // and its output is the same, so the frame stays
  EXPECT_EQ(result.outcomes[2].reason, "tool pack was rebuilt");
}

// A tool may load it: its results are as good as the module.
TEST(Build, RebuiltModuleRunsAllToolsAgain) {
  Workshop workshop;
  workshop.disk.write("lib/bakelight/pictures.so", "1");
  workshop.run();
  workshop.toolsStarted();
  workshop.run();
  EXPECT_THAT(workshop.toolsStarted(), IsEmpty());
  workshop.disk.write("lib/bakelight/pictures.so", "2");
  workshop.run();
  EXPECT_EQ(workshop.toolsStarted().size(), 4u);
}

TEST(Build, EditedAndDeletedOutputsAreRestoredFromTheCache) {
  Workshop workshop;
  workshop.run();
  workshop.toolsStarted();
  const std::string glb = workshop.disk.read("out/cube/cube.glb");
  workshop.disk.write("out/cube/cube.glb", std::string(glb.size(), 'x'));
  workshop.disk.removeAll("out/cube/simplify/mesh.ply");
  EXPECT_EQ(workshop.explain()["pack"], "would be restored: cube.glb was edited");
  EXPECT_EQ(workshop.explain()["simplify"], "would be restored: mesh.ply is missing");
  workshop.run();
  EXPECT_THAT(workshop.toolsStarted(), IsEmpty());
  EXPECT_EQ(workshop.disk.read("out/cube/cube.glb"), glb);
  EXPECT_EQ(workshop.disk.read("out/cube/simplify/mesh.ply"), "eight corners at 100");
}

std::string cachedFile(const Workshop& workshop, const std::string& name) {
  for (const std::string& path : workshop.disk.pathsContaining("out/.cache/"))
    if (path.ends_with(name)) return path;
  ADD_FAILURE() << "no " << name << " in the cache";
  return "";
}

TEST(Build, DamagedCacheEntryIsMadeAgain) {
  for (const std::string damage : {"short", "same length, other"}) {
    Workshop workshop;
    workshop.run();
    workshop.toolsStarted();
    const std::string path = cachedFile(workshop, "/mesh.ply");
    const std::string whole = workshop.disk.read(path);
    workshop.disk.write(path, damage == "short" ? whole.substr(1) : std::string(whole.size(), 'x'));
    const BuildResult result = workshop.run();
    EXPECT_EQ(workshop.toolsStarted(), (Tools{"simplify"})) << damage;
    EXPECT_EQ(result.outcomes[0].reason, "mesh.ply is damaged in the cache");
    EXPECT_EQ(workshop.disk.read(path), whole);
  }
}

TEST(Build, EntryWithoutItsManifestIsMadeAgain) {
  Workshop workshop;
  workshop.run();
  workshop.toolsStarted();
  const std::string mesh = cachedFile(workshop, "/mesh.ply");
  const std::filesystem::path manifest = std::filesystem::path(mesh).parent_path() / "entry.json";
  workshop.disk.removeAll(manifest);
  EXPECT_EQ(workshop.run().outcomes[0].reason, "entry.json is missing in the cache");
  workshop.toolsStarted();
  workshop.disk.write(manifest, "{ half");
  EXPECT_EQ(workshop.run().outcomes[0].reason, "entry.json is damaged in the cache");
  EXPECT_EQ(workshop.toolsStarted(), (Tools{"simplify"}));
}

TEST(Build, FailingStageStopsItsUsersOnly) {
  Workshop workshop;
  workshop.addAsset("bad", "hole");
  workshop.failing_mesh = "hole";
  const BuildResult result = workshop.run({"assets"});
  EXPECT_EQ(result.exitStatus(), 2);
  EXPECT_EQ(workshop.record("bad")["stages"]["simplify"]["status"], "ran");
  EXPECT_EQ(workshop.record("bad")["stages"]["transfer"]["status"], "failed");
  EXPECT_THAT(workshop.record("bad")["stages"]["transfer"]["error"], HasSubstr("face 3: has no area"));
  EXPECT_EQ(workshop.record("bad")["stages"]["pack"]["status"], "not-run");
  EXPECT_EQ(workshop.record("bad")["stages"]["frame"]["reason"], "transfer failed");
  EXPECT_EQ(workshop.record("cube")["stages"]["frame"]["status"], "ran");
  EXPECT_THAT(workshop.disk.pathsContaining("tmp-"), IsEmpty());

  workshop.failing_mesh.clear();
  workshop.toolsStarted();
  EXPECT_EQ(workshop.explain({"assets/bad"})["transfer"], "would run: failed last time");
  EXPECT_EQ(workshop.run({"assets"}).exitStatus(), 0);
  EXPECT_EQ(workshop.toolsStarted(), (Tools{"transfer", "pack", "player"}));
}

TEST(Build, FailureKeepsWhatIsKnownOfTheOutputsThatLieThere) {
  Workshop workshop;
  workshop.run();
  workshop.options.settings = {parseSetting("simplify.triangles=7")};
  workshop.failing_mesh = "eight corners at 7";
  EXPECT_EQ(workshop.run().exitStatus(), 2);
  workshop.options.settings = {parseSetting("transfer.order=2")};
  EXPECT_EQ(workshop.explain()["transfer"], "would run: order changed from 5 to 2; failed last time");
}

TEST(Build, KilledToolIsReportedAsABugWithTheSignal) {
  Workshop workshop;
  workshop.runner.killed_by["transfer"] = SIGSEGV;
  const BuildResult result = workshop.run();
  EXPECT_EQ(result.exitStatus(), 128 + SIGSEGV);
  ASSERT_TRUE(result.outcomes[1].error);
  EXPECT_THAT(result.outcomes[1].error->paragraph(), HasSubstr("killed by SIGSEGV"));
  EXPECT_THAT(result.outcomes[1].error->paragraph(), HasSubstr("bug"));
}

TEST(Build, ToolThatWritesNoOutputFails) {
  Workshop workshop;
  FakeTool lazy{nlohmann::json::parse(workshop.runner.capture({"tools/transfer"}).output),
                [](const auto&, const auto&) { return std::map<std::string, std::string>(); }};
  workshop.runner.install("transfer", lazy, "lazy");
  const BuildResult result = workshop.run();
  EXPECT_EQ(result.outcomes[1].status, StageStatus::kFailed);
  EXPECT_THAT(result.outcomes[1].error->paragraph(), HasSubstr("did not write this file"));
  EXPECT_THAT(workshop.disk.pathsContaining("tmp-"), IsEmpty());
}

TEST(Build, InterruptionLeavesNoTemporariesAndTheNextRunGoesOn) {
  Workshop workshop;
  workshop.runner.interrupt_after = 2;  // while transfer runs
  EXPECT_EQ(workshop.run().exitStatus(), 130);
  EXPECT_EQ(workshop.toolsStarted(), (Tools{"simplify", "transfer"}));
  EXPECT_THAT(workshop.disk.pathsContaining("tmp-"), IsEmpty());
  EXPECT_EQ(workshop.record()["stages"]["simplify"]["status"], "ran");
  EXPECT_EQ(workshop.record()["stages"]["transfer"]["status"], "not-run");
  EXPECT_EQ(workshop.record()["stages"]["frame"]["reason"], "interrupted");

  Workshop next;
  next.disk = workshop.disk;
  EXPECT_EQ(next.run().exitStatus(), 0);
  EXPECT_EQ(next.toolsStarted(), (Tools{"transfer", "pack", "player"}));
}

// The number of a process that is no more.
pid_t endedProcess() {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  ::waitpid(child, nullptr, 0);
  return child;
}

TEST(Build, TemporariesOfAKilledDriverAreRemovedAndThoseOfLivingOnesAreNot) {
  FakeDisk disk;
  const std::string ended = std::to_string(endedProcess()), living = std::to_string(::getpid());
  const auto temporary = [](const std::string& owner) {
    return "out/.cache/tmp-0123@" + owner + "-0/mesh.ply";
  };
  disk.write(temporary("here-" + ended), "half");
  disk.write(temporary("here-" + living), "half");
  disk.write(temporary("there-" + ended), "half");
  disk.write("out/.cache/01/0123/mesh.ply", "whole");
  Memo memo("out/.cache/memo.json", disk);
  Cache cache("out/.cache", disk, memo, {"here", ::getpid()});
  cache.removeTemporaries();
  EXPECT_THAT(disk.paths(), ElementsAre("out/.cache/01/0123/mesh.ply", temporary("here-" + living),
                                        temporary("there-" + ended)));
  disk.passTime(std::chrono::hours(8 * 24));
  cache.removeTemporaries();
  EXPECT_THAT(disk.paths(), ElementsAre("out/.cache/01/0123/mesh.ply"));
}

// As on a file system that has no locks.
TEST(Build, TwoDriversThatMakeOneEntryTakeTheOneThatIsThereFirst) {
  FakeDisk disk;
  Memo memo("out/.cache/memo.json", disk);
  Cache mine("out/.cache", disk, memo, {"here", 1}), theirs("out/.cache", disk, memo, {"there", 1});
  Ingredients ingredients;
  ingredients.outputs = {{"mesh", "mesh.ply"}};
  formats::StageRecord record;
  record.tool = "simplify";
  const auto make = [&](Cache& cache, const std::string& content) {
    const auto folder = cache.startEntry("0123");
    disk.write(folder / "mesh.ply", content);
    disk.write(folder / kStatsFile, formats::toJson(record).dump());
  };
  make(mine, "mine");
  make(theirs, "theirs");
  const CacheEntry first = theirs.finishEntry("0123", ingredients, {});
  const CacheEntry second = mine.finishEntry("0123", ingredients, {});
  EXPECT_EQ(second.folder, first.folder);
  EXPECT_EQ(disk.read(second.pathOf(second.outputs.at("mesh"))), "theirs");
  EXPECT_THAT(disk.pathsContaining("tmp-"), IsEmpty());
}

TEST(Build, FullDiskFailsTheStageAndLeavesNothingHalfDone) {
  Workshop workshop;
  workshop.disk.full = "out/cube/transfer/transfer.safetensors";
  const BuildResult result = workshop.run();
  EXPECT_EQ(result.exitStatus(), 4);
  EXPECT_EQ(result.outcomes[1].status, StageStatus::kFailed);
  EXPECT_EQ(result.outcomes[2].status, StageStatus::kNotRun);
  workshop.disk.full = "";
  workshop.toolsStarted();
  EXPECT_EQ(workshop.run().exitStatus(), 0);
  EXPECT_EQ(workshop.toolsStarted(), (Tools{"pack", "player"}));  // the cache has what transfer made
}

TEST(Build, RecordThatCannotBeWrittenIsToldByTheExitStatus) {
  Workshop workshop;
  workshop.disk.full = "record.json";
  EXPECT_EQ(workshop.run().exitStatus(), 4);
}

TEST(Build, JobsRunAtOnceWithinTheBudgetOfCores) {
  Workshop workshop;
  for (int i = 0; i < 6; ++i) workshop.addAsset("mesh" + std::to_string(i), "mesh " + std::to_string(i));
  workshop.settings = {.jobs = 3, .cores = 4};
  EXPECT_EQ(workshop.run({"assets"}).exitStatus(), 0);
  EXPECT_EQ(workshop.runner.most_at_once, 3u);
  EXPECT_EQ(workshop.runner.most_threads_at_once, 4);
}

TEST(Build, OneJobGetsAllCores) {
  Workshop workshop;
  workshop.settings = {.jobs = 8, .cores = 6};
  workshop.run();
  for (const auto& command : workshop.runner.commands) EXPECT_EQ(valueOf(command, "--threads"), "6");
  EXPECT_EQ(workshop.runner.commands.size(), 4u);
}

TEST(Build, OutputsDoNotDependOnTheOrderInWhichStagesEnd) {
  std::vector<std::string> glbs;
  for (const bool last_first : {false, true}) {
    Workshop workshop;
    for (int i = 0; i < 6; ++i) workshop.addAsset("mesh" + std::to_string(i), "mesh " + std::to_string(i));
    workshop.settings = {.jobs = 4, .cores = 4};
    workshop.runner.last_started_ends_first = last_first;
    EXPECT_EQ(workshop.run({"assets"}).exitStatus(), 0);
    std::string all;
    for (const std::string& path : workshop.disk.pathsContaining("/mesh"))
      if (path.ends_with(".glb") && path.starts_with("out/mesh")) all += path + workshop.disk.read(path);
    glbs.push_back(all);
  }
  EXPECT_THAT(glbs[0], HasSubstr("mesh 5"));
  EXPECT_EQ(glbs[0], glbs[1]);
}

TEST(Build, EqualWorkOfTwoAssetsIsDoneOnce) {
  Workshop workshop;
  workshop.addAsset("twin", "eight corners");
  workshop.settings = {.jobs = 4, .cores = 4};
  EXPECT_EQ(workshop.run({"assets"}).exitStatus(), 0);
  const Tools started = workshop.toolsStarted();
  EXPECT_EQ(std::count(started.begin(), started.end(), "simplify"), 1);
  EXPECT_EQ(std::count(started.begin(), started.end(), "transfer"), 1);
  EXPECT_EQ(std::count(started.begin(), started.end(), "pack"), 2);  // the name differs
  EXPECT_EQ(workshop.disk.read("out/twin/simplify/mesh.ply"),
            workshop.disk.read("out/cube/simplify/mesh.ply"));
}

TEST(Build, NothingToDoForTwoHundredAssetsReadsEachManifestAndRecordOnce) {
  Workshop workshop;
  for (int i = 0; i < 199; ++i) workshop.addAsset("mesh" + std::to_string(i), "mesh " + std::to_string(i));
  workshop.settings = {.jobs = 8, .cores = 8};
  workshop.run({"assets"});
  workshop.run({"assets"});
  workshop.toolsStarted();
  workshop.disk.reads = workshop.disk.hashes = workshop.disk.writes = 0;
  workshop.run({"assets"});
  EXPECT_THAT(workshop.toolsStarted(), IsEmpty());
  EXPECT_EQ(workshop.disk.hashes, 0);
  EXPECT_EQ(workshop.disk.writes, 0);
  EXPECT_EQ(workshop.disk.reads, 200 * (4 + 1) + 2);  // manifests and record; recipe and memo
}

TEST(Build, RecordCarriesTheFiguresOfTheRunThatMadeTheOutputs) {
  Workshop workshop;
  workshop.run();
  workshop.run();
  const auto stage = workshop.record()["stages"]["transfer"];
  EXPECT_EQ(stage["status"], "cached");
  EXPECT_EQ(stage["reason"], "up to date");
  EXPECT_EQ(stage["wall_s"], 1.5);
  EXPECT_EQ(stage["cpu_s"], 2.5);
  EXPECT_EQ(stage["peak_memory_bytes"], 4096);
  EXPECT_EQ(stage["stats"]["inputs"], 1);
  EXPECT_EQ(stage["outputs"]["transfer"]["path"], "transfer/transfer.safetensors");
  EXPECT_EQ(stage["outputs"]["transfer"]["bytes"], 28);
  EXPECT_EQ(stage["outputs"]["transfer"]["hash"].get<std::string>().size(), 32u);
  EXPECT_EQ(stage["key"].get<std::string>().size(), 32u);
}

TEST(Build, StageThatNothingDeliveredNeedsIsLeftOutAndSaysSo) {
  Workshop workshop;
  workshop.options.deliver = {"pack"};
  EXPECT_EQ(workshop.run().exitStatus(), 0);
  EXPECT_EQ(workshop.toolsStarted(), (Tools{"simplify", "transfer", "pack"}));
  EXPECT_EQ(workshop.record()["stages"]["frame"]["status"], "left-out");
  EXPECT_EQ(workshop.record()["stages"]["frame"]["reason"], "nothing delivered needs it");
}

}  // namespace
}  // namespace bakelight::pipeline
