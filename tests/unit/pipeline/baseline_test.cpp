// Real files in temporary folders: what is compared here is what the formats' own libraries read.
#include "pipeline/baseline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "fakes.h"
#include "formats/btf_writer.h"
#include "formats/hash.h"
#include "formats/image.h"
#include "formats/mesh_ply.h"
#include "formats/pack.h"
#include "formats/tensors.h"
#include "pipeline/local_runner.h"
#include "pipeline/problems.h"
#include "tests/support/shapes.h"
#include "tests/support/temporary_folder.h"

namespace bakelight::pipeline {
namespace {

namespace fs = std::filesystem;
using formats::Json;
using testing::Contains;
using testing::HasSubstr;

formats::TriangleMesh sphere() {
  return tests::icosphere(2);
}

formats::TensorFile tensors(float first = 0.25f, float others = 0.5f) {
  std::vector<float> values(1200, others);
  values[0] = first;
  formats::TensorFile file;
  file.tensors["transfer"] =
      formats::Tensor::from<float>(formats::ElementType::kFloat32, {100, 12}, std::span<const float>(values));
  file.metadata = {{"order", "2"}, {"mesh_hash", "aa"}};
  return file;
}

formats::Image picture(float first = 0.25f) {
  formats::Image image(8, 4, {"R", "G", "B"});
  for (float& value : image.values) value = 0.5f;
  image.values[0] = first;
  return image;
}

formats::Pack pack(float first = 0.25f) {
  formats::Pack result;
  result.name = "ball";
  result.mesh = sphere();
  result.sh().order = 1;
  result.sh().channels = 1;
  std::vector<float> values(result.mesh.vertexCount(), 0.5f);
  values[0] = first;
  result.sh().vectors = formats::encodeTable(values, 1, formats::Precision::kFloat32, "", "");
  return result;
}

// Stages whose outputs lie in folders, as the cache keeps them.
class BaselineTest : public testing::Test {
 protected:
  BaselineTest() {
    made.stages.resize(5);
    define(0, "simplify", "simplified", "mesh", "mesh.ply");
    define(1, "transfer", "transfer", "tensors", "transfer.safetensors");
    define(2, "pack", "pack", "pack", "ball.glb");
    define(3, "frame", "image", "image", "frame.exr");
    define(4, "page", "notes", "notes", "notes.txt");
    writeMesh(sphere());
    formats::writeSafetensors(fileOf(1), tensors());
    formats::writePack(fileOf(2), pack(), {});
    formats::writeExr(fileOf(3), picture(), formats::ExrPrecision::kFloat);
    disk.write(fileOf(4), "notes");
    made.stages[1].entry.run.stats = {{"rays", 4096},
                                      {"bake_s", 3},
                                      {"gpu_bytes", 10},
                                      {"share", 0.25},
                                      {"passes", {3, 5}},
                                      {"closed", true},
                                      {"seconds_s", {{"repair", 7}}},
                                      {"rays_per_s", 5},
                                      {"bytes", 99}};
    made.stages[1].parameters = {{"order", 5}};
    rehash();
  }

  void define(std::size_t index, const std::string& stage, const std::string& port, const std::string& kind,
              const std::string& file) {
    MadeStage& entry = made.stages[index];
    entry.stage = entry.tool = stage;
    entry.parameters = Json::object();
    entry.kinds[port] = kind;
    entry.entry.folder = temporary / ("cache-" + stage);
    entry.entry.outputs[port] = {file, 0, ""};
    disk.makeFolders(entry.entry.folder);
  }
  fs::path fileOf(std::size_t index) const {
    const CacheEntry& entry = made.stages[index].entry;
    return entry.pathOf(entry.outputs.begin()->second);
  }
  void writeMesh(const formats::TriangleMesh& mesh) { formats::writePly(fileOf(0), mesh); }
  void rehash() {
    for (std::size_t i = 0; i < made.stages.size(); ++i)
      for (auto& [port, file] : made.stages[i].entry.outputs)
        file.hash = disk.hash(made.stages[i].entry.pathOf(file));
  }

  void save() { saveBaseline(made, folder, disk); }
  BaselineReport check() {
    rehash();
    return checkBaseline(made, folder, disk, formats::compareFiles);
  }
  Json stored() { return formats::readJson(folder / kBaselineFile); }
  void edit(const Json& json) { disk.write(folder / kBaselineFile, json.dump()); }
  void editLimit(const std::string& stage, const std::string& port, const std::string& limit, double value) {
    Json json = stored();
    json["stages"][stage]["outputs"][port]["limits"][limit] = value;
    edit(json);
  }
  // What a check throws; "" if nothing.
  std::string checkError() {
    try {
      check();
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), ExitStatus::kBadInput);
      return error.what();
    } catch (const ProblemsFound& problems) {
      EXPECT_EQ(problems.errors().front().status(), ExitStatus::kBadInput);
      return problems.what();
    }
    return "";
  }

  // The stages that differ, each once.
  static std::set<std::string> differing(const BaselineReport& report) {
    std::set<std::string> stages;
    for (const BaselineRow& row : report.rows)
      if (!row.passes) stages.insert(row.stage);
    return stages;
  }
  void expectOnlyDiffers(const std::string& stage) {
    const BaselineReport report = check();
    EXPECT_EQ(differing(report), std::set<std::string>{stage});
    EXPECT_EQ(report.exitStatus(), 1);
  }
  void expectPasses() {
    const BaselineReport report = check();
    std::ostringstream text;
    print(report, text);
    EXPECT_EQ(report.exitStatus(), 0) << text.str();
    EXPECT_EQ(report.compared_outputs, made.stages.size());
  }

  tests::TemporaryFolder temporary;
  RealDisk disk;
  MadeAsset made{"ball", "prt", {}};
  const fs::path folder = temporary / "baseline";
};

TEST_F(BaselineTest, EqualOutputsPass) {
  save();
  expectPasses();
}

// Other bytes, the same within the limits: read and measured, not only hashed.
TEST_F(BaselineTest, EachKindPassesWithinItsLimits) {
  save();
  formats::TriangleMesh mesh = sphere();
  mesh.positions[5][0] += 2e-6f;
  writeMesh(mesh);
  formats::TensorFile file = tensors(0.2501f);
  file.metadata["mesh_hash"] = "bb";
  formats::writeSafetensors(fileOf(1), file);
  formats::writePack(fileOf(2), pack(0.2501f), {});
  formats::writeExr(fileOf(3), picture(0.26f), formats::ExrPrecision::kFloat);
  expectPasses();
  std::size_t measured = 0;
  for (const BaselineRow& row : check().rows)
    if (!row.measured.empty() && row.measured != "equal" && std::stod(row.measured) > 0) ++measured;
  EXPECT_GE(measured, 7u);
}

TEST_F(BaselineTest, MovedVertexDiffers) {
  save();
  formats::TriangleMesh mesh = sphere();
  mesh.positions[5][0] += 1e-3f;
  writeMesh(mesh);
  expectOnlyDiffers("simplify");
}

TEST_F(BaselineTest, TurnedNormalDiffers) {
  save();
  formats::TriangleMesh mesh = sphere();
  std::swap(mesh.normals[5][0], mesh.normals[5][1]);
  writeMesh(mesh);
  expectOnlyDiffers("simplify");
}

TEST_F(BaselineTest, VertexMoreDiffers) {
  save();
  writeMesh(tests::icosphere(1));
  expectOnlyDiffers("simplify");
}

TEST_F(BaselineTest, OneValueOfATensorBeyondTheMaximumDiffers) {
  save();
  formats::writeSafetensors(fileOf(1), tensors(0.27f));
  expectOnlyDiffers("transfer");
}

TEST_F(BaselineTest, ManyValuesOfATensorBeyondTheNormDiffer) {
  save();
  formats::writeSafetensors(fileOf(1), tensors(0.25f, 0.501f));  // each within the maximum
  expectOnlyDiffers("transfer");
}

TEST_F(BaselineTest, NotANumberDiffers) {
  save();
  formats::writeSafetensors(fileOf(1), tensors(std::numeric_limits<float>::quiet_NaN()));
  expectOnlyDiffers("transfer");
}

TEST_F(BaselineTest, MetadataOfATensorDiffers) {
  save();
  formats::TensorFile file = tensors();
  file.metadata["order"] = "3";
  formats::writeSafetensors(fileOf(1), file);
  expectOnlyDiffers("transfer");
}

TEST_F(BaselineTest, TableOfAPackDiffers) {
  save();
  formats::writePack(fileOf(2), pack(0.3f), {});
  expectOnlyDiffers("pack");
}

TEST_F(BaselineTest, OneChannelOfAnImageDiffers) {
  save();
  formats::Image image = picture();
  for (std::size_t i = 2; i < image.values.size(); i += 3) image.values[i] += 0.01f;
  formats::writeExr(fileOf(3), image, formats::ExrPrecision::kFloat);
  const BaselineReport report = check();
  std::vector<std::string> figures;
  for (const BaselineRow& row : report.rows)
    if (!row.passes) figures.push_back(row.figure);
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_THAT(figures.front(), HasSubstr("B"));
}

TEST_F(BaselineTest, OtherKindsAreComparedByteByByte) {
  save();
  disk.write(fileOf(4), "Notes");
  expectOnlyDiffers("page");
}

TEST_F(BaselineTest, CountsAgreeExactly) {
  save();
  made.stages[1].entry.run.stats["rays"] = 4097;
  expectOnlyDiffers("transfer");
  made.stages[1].entry.run.stats["rays"] = 4096;
  made.stages[1].entry.run.stats["passes"][1] = 6;
  expectOnlyDiffers("transfer");
  made.stages[1].entry.run.stats["passes"][1] = 5;
  made.stages[1].entry.run.stats["more"] = 0;
  expectOnlyDiffers("transfer");
  made.stages[1].entry.run.stats.erase("more");
  made.stages[1].entry.run.stats.erase("rays");
  expectOnlyDiffers("transfer");
}

TEST_F(BaselineTest, TimesMemoryAndFractionsAreNoCounts) {
  save();
  Json& stats = made.stages[1].entry.run.stats;
  stats["bake_s"] = 4, stats["gpu_bytes"] = 11, stats["rays_per_s"] = 6, stats["share"] = 0.5;
  stats["seconds_s"]["repair"] = 8;
  expectPasses();
  EXPECT_EQ(stored()["stages"]["transfer"]["counts"],
            Json({{"/rays", 4096}, {"/passes/0", 3}, {"/passes/1", 5}, {"/bytes", 99}}));
}

TEST_F(BaselineTest, EditedLimitsCount) {
  save();
  formats::writeSafetensors(fileOf(1), tensors(0.27f));
  expectOnlyDiffers("transfer");
  editLimit("transfer", "transfer", "maximum", 0.05);
  editLimit("transfer", "transfer", "relative", 0.05);
  expectPasses();
  formats::writeExr(fileOf(3), picture(0.26f), formats::ExrPrecision::kFloat);
  expectPasses();
  editLimit("frame", "image", "maximum", 0);
  expectOnlyDiffers("frame");
}

TEST_F(BaselineTest, CountsCanBeIgnored) {
  save();
  made.stages[1].entry.run.stats["rays"] = 5000;
  Json json = stored();
  json["stages"]["transfer"]["ignored_counts"] = {"/rays"};
  edit(json);
  expectPasses();
  json["stages"]["transfer"]["ignored_counts"] = {"/raise"};
  edit(json);
  EXPECT_THAT(checkError(), HasSubstr("/stages/transfer/ignored_counts"));
}

TEST_F(BaselineTest, StageThatIsNotMadeAnyMoreDiffers) {
  save();
  made.stages.erase(made.stages.begin() + 1);
  expectOnlyDiffers("transfer");
  EXPECT_TRUE(check().notes.empty());
  made.left_out["transfer"] = "it adds nothing";
  EXPECT_EQ(check().notes, std::vector<std::string>{"transfer: left out in this run (it adds nothing)"});
}

TEST_F(BaselineTest, StageThatIsNewDiffers) {
  const MadeStage frame = made.stages[3];
  made.stages.erase(made.stages.begin() + 3);
  save();
  made.stages.push_back(frame);
  expectOnlyDiffers("frame");
}

TEST_F(BaselineTest, OutputThatIsGoneOrNewDiffers) {
  save();
  const CacheEntry entry = made.stages[1].entry;
  made.stages[1].entry.outputs.clear();
  expectOnlyDiffers("transfer");
  made.stages[1].entry = entry;
  made.stages[1].entry.outputs["more"] = entry.outputs.at("transfer");
  made.stages[1].kinds["more"] = "tensors";
  expectOnlyDiffers("transfer");
}

// A measured or rendered BTF is compared by its values, within the limits of its kind.
TEST_F(BaselineTest, BtfsHaveLimits) {
  define(4, "rtt", "btf", "btf", "patch.btf");
  made.stages[4].entry.outputs.erase("notes");
  made.stages[4].kinds.erase("notes");
  const auto write = [&](float value) {
    formats::BtfInfo info;
    info.width = info.height = 2;
    info.lights = info.views = {{0.2, 0}, {0.9, 1}};
    formats::writeRawBtf(fileOf(4), *formats::btfOf(info, std::vector<float>(48, value)));
    rehash();
  };
  write(0.5F);
  save();
  EXPECT_EQ(check().differenceCount(), 0U);
  write(0.75F);
  expectOnlyDiffers("rtt");
  editLimit("rtt", "btf", "maximum", 0.3);
  editLimit("rtt", "btf", "relative", 0.6);
  EXPECT_EQ(check().differenceCount(), 0U);
}

TEST_F(BaselineTest, NothingComparedIsNoSuccess) {
  save();
  Json json = stored();
  for (Json& stage : json["stages"]) stage["outputs"] = Json::object();
  edit(json);
  for (MadeStage& stage : made.stages) stage.entry.outputs.clear();
  const BaselineReport report = check();
  EXPECT_EQ(report.differenceCount(), 0u);
  EXPECT_EQ(report.exitStatus(), 1);
  std::ostringstream text;
  print(report, text);
  EXPECT_THAT(text.str(), HasSubstr("nothing was compared"));
  EXPECT_EQ(checkBaseline({"ball", "prt", {}}, folder, disk, formats::compareFiles).exitStatus(), 1);
  EXPECT_THROW(saveBaseline(made, temporary / "other", disk), Error);
  EXPECT_FALSE(fs::exists(temporary / "other"));
}

TEST_F(BaselineTest, ImageOfNoPixelsIsNoSuccess) {
  save();
  disk.write(fileOf(3), "other bytes, and nothing in them");
  rehash();
  const auto nothing = [](auto&&...) { return formats::Comparison(); };
  EXPECT_EQ(differing(checkBaseline(made, folder, disk, nothing)), std::set<std::string>{"frame"});
}

TEST_F(BaselineTest, ChangedParametersAreTold) {
  save();
  made.stages[1].parameters["order"] = 4;
  const BaselineReport report = check();
  EXPECT_EQ(report.exitStatus(), 0);
  EXPECT_THAT(report.notes, Contains(AllOf(HasSubstr("transfer"), HasSubstr("order changed from 5 to 4"))));
}

TEST_F(BaselineTest, AnotherExecutionPathIsTold) {
  save();
  made.stages[1].execution_path = "embree avx2";
  const BaselineReport report = check();
  EXPECT_EQ(report.exitStatus(), 0);
  EXPECT_THAT(report.notes, Contains(AllOf(HasSubstr("transfer"), HasSubstr("embree avx2"))));
}

TEST_F(BaselineTest, DamageIsFound) {
  EXPECT_THAT(checkError(), HasSubstr("is no baseline"));
  save();
  const Json good = stored();
  const auto with = [&](const std::string& pointer, const Json& value) {
    Json json = good;
    json[Json::json_pointer(pointer)] = value;
    edit(json);
    return checkError();
  };
  EXPECT_THAT(with("/recipe", "glossy"), HasSubstr("/recipe"));
  EXPECT_THAT(with("/version", 2), HasSubstr("/version"));
  EXPECT_THAT(with("/format", "asset"), HasSubstr("/format"));
  EXPECT_THAT(with("/stages", Json::object()), HasSubstr("/stages"));
  EXPECT_THAT(with("/stages/transfer/outputs/transfer/limits/maximal", 1),
              HasSubstr("/stages/transfer/outputs/transfer/limits/maximal"));
  EXPECT_THAT(with("/stages/transfer/outputs/transfer/limits/maximum", -1), HasSubstr("limits/maximum"));
  EXPECT_THAT(with("/stages/transfer/outputs/transfer/limits/maximum", "a lot"), HasSubstr("limits/maximum"));
  EXPECT_THAT(with("/stages/transfer/outputs/transfer/limits/rms", 1), HasSubstr("limits/rms"));
  EXPECT_THAT(with("/stages/transfer/outputs/transfer/file", "else.safetensors"), HasSubstr("is missing"));
  EXPECT_THAT(with("/stages/transfer/counts/~1rays", 0.5), HasSubstr("is not a count"));
  disk.write(folder / kBaselineFile, good.dump().substr(0, 100));
  EXPECT_NE(checkError(), "");
  edit(good);
  EXPECT_EQ(checkError(), "");
  formats::writeSafetensors(folder / "transfer/transfer.safetensors", tensors(0.3f));
  EXPECT_THAT(checkError(), HasSubstr("is not as it was saved"));
}

TEST_F(BaselineTest, NewOneReplacesTheOldOneWhole) {
  save();
  disk.write(folder / "stale.txt", "");
  formats::writeSafetensors(fileOf(1), tensors(0.9f));
  rehash();
  save();
  expectPasses();
  EXPECT_FALSE(fs::exists(folder / "stale.txt"));
  EXPECT_EQ(disk.list(temporary.path()).front(), "baseline");
  EXPECT_EQ(temporary.entryCount(), 1 + made.stages.size());  // nothing is left beside it
}

TEST_F(BaselineTest, OldOneStaysWhenANewOneFails) {
  save();
  const Json before = stored();
  fs::remove(fileOf(3));
  EXPECT_THROW(save(), Error);
  EXPECT_EQ(stored(), before);
  EXPECT_EQ(temporary.entryCount(), 1 + made.stages.size());
}

TEST_F(BaselineTest, NeverReplacesSomethingElse) {
  disk.write(folder / "precious.txt", "content");
  EXPECT_THROW(save(), Error);
  EXPECT_EQ(disk.read(folder / "precious.txt"), "content");
}

TEST_F(BaselineTest, TableNamesFiguresAndLimits) {
  save();
  formats::writeSafetensors(fileOf(1), tensors(0.27f));
  std::ostringstream text;
  print(check(), text);
  EXPECT_THAT(text.str(), testing::ContainsRegex("stage +output +kind +figure +measured +limit\n"));
  EXPECT_THAT(
      text.str(),
      testing::ContainsRegex("transfer +transfer +tensors +tensor transfer, maximum +0.02 +0.01 +DIFFERS\n"));
  EXPECT_THAT(text.str(), testing::ContainsRegex("simplify +simplified +mesh +bytes +equal +ok\n"));
  EXPECT_THAT(text.str(), HasSubstr("2 differences from the baseline\n"));
}

// The tool answers what the library would.
TEST_F(BaselineTest, CompareToolMeasuresTheSame) {
  save();
  formats::TriangleMesh mesh = sphere();
  mesh.positions[5][0] += 1e-3f;
  writeMesh(mesh);
  formats::TensorFile file = tensors(std::numeric_limits<float>::quiet_NaN());
  file.metadata["mesh_hash"] = "bb";
  formats::writeSafetensors(fileOf(1), file);
  formats::writePack(fileOf(2), pack(0.3f), {});
  formats::writeExr(fileOf(3), picture(0.26f), formats::ExrPrecision::kFloat);
  rehash();
  LocalRunner runner;
  const BaselineReport by_tool =
      checkBaseline(made, folder, disk, compareTool(BAKELIGHT_BIN_DIR, temporary / "scratch", runner, disk));
  const BaselineReport by_library = check();
  std::ostringstream tool_text, library_text;
  print(by_tool, tool_text), print(by_library, library_text);
  EXPECT_EQ(tool_text.str(), library_text.str());
  EXPECT_EQ(differing(by_tool), (std::set<std::string>{"simplify", "transfer", "pack"}));

  disk.write(fileOf(1), "not a tensor file");
  rehash();
  EXPECT_THROW(
      checkBaseline(made, folder, disk, compareTool(BAKELIGHT_BIN_DIR, temporary / "scratch", runner, disk)),
      Error);
}

TEST(BaselineFolder, LiesBesideTheAsset) {
  EXPECT_EQ(baselineFolder({.name = "bunny", .file = "models/bunny/asset.json"}), "models/bunny/baseline");
  EXPECT_EQ(baselineFolder({.name = "bunny", .file = "models/bunny.obj"}), "models/bunny.baseline");
}

TEST(MadeAsset, TakesWhatWasMadeAndRefusesWhatFailed) {
  FakeDisk disk;
  FakeRunner runner(disk);
  Memo memo("memo.json", disk);
  runner.install("bake",
                 {{{"tool", "bake"},
                   {"summary", ""},
                   {"execution_path", ""},
                   {"inputs", Json::array()},
                   {"outputs", {{{"name", "out"}, {"kind", "tensors"}, {"required", true}, {"help", ""}}}},
                   {"parameters", Json::array()}},
                  {}});
  Toolbox tools("tools", "", disk, runner, memo);
  const Graph graph{.assets = {{.name = "a", .file = "a.obj"}, {.name = "b", .file = "b.obj"}},
                    .tasks = {{.asset = 1, .stage = "first", .tool = "bake"},
                              {.asset = 1, .stage = "second", .tool = "bake"},
                              {.asset = 0, .stage = "first", .tool = "bake"}}};
  BuildResult result;
  result.outcomes.resize(3);
  result.outcomes[0].status = StageStatus::kLeftOut;
  result.outcomes[0].reason = "it adds nothing";
  result.outcomes[1].status = StageStatus::kCached;
  result.outcomes[1].ingredients.parameters = {{"order", 3}};
  result.outcomes[1].entry =
      CacheEntry{.key = "k", .folder = "f", .outputs = {{"out", {"t.safetensors", 1, "h"}}}};
  result.outcomes[2].status = StageStatus::kFailed;
  result.outcomes[2].reason = "failed";
  const MadeAsset made = madeAsset(graph, 1, result, tools);
  ASSERT_EQ(made.stages.size(), 1u);
  EXPECT_EQ(made.name, "b");
  EXPECT_EQ(made.left_out, (std::map<std::string, std::string>{{"first", "it adds nothing"}}));
  EXPECT_EQ(made.stages[0].stage, "second");
  EXPECT_EQ(made.stages[0].kinds.at("out"), "tensors");
  EXPECT_EQ(made.stages[0].parameters, Json({{"order", 3}}));
  EXPECT_THROW(madeAsset(graph, 0, result, tools), Error);
}

}  // namespace
}  // namespace bakelight::pipeline
