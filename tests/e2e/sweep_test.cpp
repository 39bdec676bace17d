// Sweeps, budgets and leaving out through the real tools, on small bodies.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "formats/file.h"
#include "formats/mesh_ply.h"
#include "formats/pack.h"
#include "tests/e2e/broken_tools.h"
#include "tests/support/shapes.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

namespace bakelight::tests {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::ContainsRegex;
using testing::HasSubstr;

const fs::path kBin = BAKELIGHT_BIN_DIR;
const fs::path kBrokenStage = kBin.parent_path() / "tests/broken_stage";

// Two bodies that shade and light each other, in no symmetric position.
formats::TriangleMesh twoBodies() {
  formats::TriangleMesh mesh = icosphere(2);
  append(mesh, icosphere(2, 0.6, {1.2, 0.9, 0.4}));
  return mesh;
}

class Sweep : public testing::Test {
 protected:
  void writeAsset(const formats::TriangleMesh& mesh, Json asset) {
    formats::writePly(asset_ / "bodies.ply", mesh);
    asset["mesh"] = "bodies.ply";
    // Seen from one side, small.
    asset["report"]["cameras"] = {{"front", {{"yaw_deg", 25}, {"width", 48}, {"height", 48}}}};
    std::ofstream(asset_ / "asset.json") << asset;
  }

  ShellOutcome bakelight(const std::string& command, const std::string& options = "",
                         const fs::path& tools = kBin) {
    std::string line = kBin / "bakelight";
    line.append(" ").append(command).append(" '").append(asset_.string());
    line.append("' --out '").append((folder_ / "out").string());
    line.append("' --tools '").append(tools.string()).append("' ").append(options);
    return shell(line);
  }

  Json json(const std::string& file) const {
    return Json::parse(formats::readTextFile(folder_ / "out/bodies" / file));
  }

  double errorWith(const fs::path& tools) {
    const ShellOutcome swept = bakelight("sweep", "--vary transfer.order=4", tools);
    EXPECT_EQ(swept.status, 0) << swept.output;
    const Json report = json("report.json");
    EXPECT_EQ(report.at("variants").size(), 1u);
    return report.at("variants")[0].at("rel_rmse");
  }

  double errorWithBroken(const std::string& kind) {
    const fs::path tools = folder_ / kind;
    makeBrokenTools(tools, kBin, kBrokenStage, kind);
    return errorWith(tools);
  }

  TemporaryFolder folder_;
  const fs::path asset_ = folder_ / "bodies";
};

TEST_F(Sweep, ErrorOfTheReportCatchesABrokenDiffuseTransfer) {
  writeAsset(twoBodies(), {{"stages", {{"transfer", {{"transport", "interreflected"}}}}}});
  const double good = errorWith(kBin);
  EXPECT_LT(good, 0.06);
  EXPECT_GT(good, 0.0005) << "five bands of light and some triangles are not the truth";
  for (const char* kind : {"dropped_pi", "flipped_axis", "turned_vectors"})
    EXPECT_GT(errorWithBroken(kind), 0.1 + 2 * good) << kind;
  EXPECT_DOUBLE_EQ(errorWith(kBin), good) << "the good tools are back";
}

TEST_F(Sweep, ErrorOfTheReportCatchesTurnedFramesOfGlossyTransfer) {
  writeAsset(twoBodies(),
             {{"recipe", "glossy"},
              {"material",
               {{"albedo", {0.05, 0.05, 0.05}},
                {"reflection", {{"model", "ggx"}, {"specular_color", {0.9, 0.9, 0.9}}, {"roughness", 0.7}}}}},
              {"stages", {{"transfer", {{"storage", "matrix"}}}}}});
  const double good = errorWith(kBin);
  EXPECT_LT(good, 0.2);
  EXPECT_GT(errorWithBroken("turned_frames"), 1.5 * good);
}

// Rough facets lose light that the lobe does not: all of that is the link from the physical picture to the
// one that is traced with what the player has.
TEST_F(Sweep, TheMaterialIsACauseOfItsOwn) {
  writeAsset(twoBodies(),
             {{"recipe", "glossy"},
              {"material",
               {{"albedo", {0.05, 0.05, 0.05}},
                {"reflection", {{"model", "ggx"}, {"specular_color", {0.9, 0.9, 0.9}}, {"roughness", 0.8}}}}},
              {"stages", {{"transfer", {{"storage", "matrix"}, {"transport", "shadowed"}}}}}});
  const ShellOutcome swept = bakelight("sweep", "--vary pack.reflection=lobe,table");
  ASSERT_EQ(swept.status, 0) << swept.output;
  std::map<std::string, double> material;
  const Json report = json("report.json");
  for (const Json& variant : report.at("variants")) {
    double sum = 0;
    std::vector<std::string> causes;
    for (const Json& cause : variant.at("causes")) {
      causes.push_back(cause.at("cause"));
      sum += cause.at("rel_rmse").get<double>();
      if (causes.back() == "material") material[variant.at("name")] = cause.at("rel_rmse");
    }
    EXPECT_THAT(causes, testing::IsSupersetOf({"transport", "simplification", "material", "interpolation",
                                               "sh_truncation", "directions", "storage"}));
    EXPECT_GT(causes.size(), 3U);
    EXPECT_EQ(causes[2], "material");
    EXPECT_LE(variant.at("rel_rmse").get<double>(), sum + 0.01) << "steps add up to the whole way or more";
  }
  EXPECT_GT(material["reflection=lobe"], 0.2);
  EXPECT_LT(material["reflection=table"], 0.04);
}

TEST_F(Sweep, ConvexBodyIsBakedWithoutRaysAndSaysSo) {
  writeAsset(icosphere(3), {{"stages", {{"transfer", {{"transport", "interreflected"}}}}}});
  const ShellOutcome ran = bakelight("run");
  ASSERT_EQ(ran.status, 0) << ran.output;
  EXPECT_THAT(ran.output, HasSubstr("leaves out shadow rays and bounces: survey.concavity"));
  const Json stages = json("record.json").at("stages");
  EXPECT_EQ(stages.at("survey").at("stats").at("rays"), 0);
  EXPECT_EQ(stages.at("transfer").at("stats").at("rays"), 0);
  EXPECT_EQ(stages.at("transfer").at("ingredients").at("parameters").at("transport"), "unshadowed");
  const Json omission = stages.at("transfer").at("left_out").at(0);
  EXPECT_EQ(omission.at("error"), 0);
  EXPECT_LE(omission.at("value").get<double>(), omission.at("threshold").get<double>());

  const ShellOutcome swept = bakelight("sweep", "--vary transfer.order=3");
  ASSERT_EQ(swept.status, 0) << swept.output;
  const Json report = json("report.json");
  ASSERT_EQ(report.at("left_out").size(), 1u);
  EXPECT_LT(report.at("left_out")[0].at("measured_error").get<double>(), 1e-4) << "the closed form is exact";

  ASSERT_EQ(bakelight("run", "--keep-all").status, 0);
  EXPECT_GT(json("record.json").at("stages").at("transfer").at("stats").at("rays"), 0);
}

TEST_F(Sweep, BodiesThatShadeEachOtherKeepTheirRays) {
  writeAsset(twoBodies(), {{"stages", {{"transfer", {{"transport", "interreflected"}}}}}});
  const ShellOutcome ran = bakelight("run", "--deliver pack");
  ASSERT_EQ(ran.status, 0) << ran.output;
  const Json transfer = json("record.json").at("stages").at("transfer");
  EXPECT_GT(transfer.at("stats").at("rays"), 0);
  EXPECT_FALSE(transfer.contains("left_out"));
}

TEST_F(Sweep, AlbedoIsThatOfTheMaterialWithBouncesOrWithout) {
  for (const char* transport : {"shadowed", "interreflected"}) {
    writeAsset(twoBodies(), {{"material", {{"albedo", {0.25, 0.5, 0.125}}}},
                             {"stages", {{"transfer", {{"transport", transport}}}}}});
    const ShellOutcome ran = bakelight("run", "--deliver pack");
    ASSERT_EQ(ran.status, 0) << ran.output;
    EXPECT_EQ(formats::readPack(folder_ / "out/bodies/bodies.glb").appearances[0].base_color,
              (Float3{0.25F, 0.5F, 0.125F}))
        << transport;
  }
}

TEST_F(Sweep, BudgetIsKeptAndTheRecordSaysWhatElseWouldCost) {
  const auto withError = [](double error) {
    return Json{{"budget", {{"error", error}}},
                {"report", {{"vary", {"transfer.order=1..4"}}}},
                {"stages", {{"transfer", {{"transport", "interreflected"}}}}}};
  };
  writeAsset(twoBodies(), withError(0.1));
  const ShellOutcome ran = bakelight("run");
  ASSERT_EQ(ran.status, 0) << ran.output;
  const Json record = json("record.json"), choice = record.at("budget"), report = json("report.json");
  EXPECT_LE(choice.at("rel_rmse").get<double>(), 0.1);
  EXPECT_EQ(record.at("stages").at("transfer").at("ingredients").at("parameters").at("order"),
            choice.at("parameters").at("transfer.order"));
  ASSERT_EQ(report.at("variants").size(), 4u);
  for (const Json& variant : report.at("variants"))
    if (variant.at("frame_ms").get<double>() < choice.at("frame_ms").get<double>()) {
      EXPECT_GT(variant.at("rel_rmse").get<double>(), 0.1) << "faster, and within the budget";
    }
  EXPECT_LT(choice.at("next_cheaper").at("frame_ms").get<double>(), choice.at("frame_ms").get<double>());

  const ShellOutcome again = bakelight("run");
  EXPECT_THAT(again.output, HasSubstr("everything is up to date"));
  EXPECT_EQ(json("record.json").at("budget"), choice) << "nothing is measured anew";

  writeAsset(twoBodies(), withError(1e-6));
  const ShellOutcome beyond = bakelight("run");
  EXPECT_EQ(beyond.status, 2);
  EXPECT_THAT(beyond.output, HasSubstr("no variant keeps the budget"));
  EXPECT_THAT(beyond.output, ContainsRegex("the nearest is order=[0-9]"));
}

}  // namespace
}  // namespace bakelight::tests
