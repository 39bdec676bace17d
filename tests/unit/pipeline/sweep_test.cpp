// What a sweep makes of an asset: variants, packs that differ in one respect, references, and the plan of the
// report.
#include "pipeline/sweep.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "pipeline/problems.h"
#include "workshop.h"

namespace bakelight::pipeline {
namespace {

using Json = nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

Json port(const std::string& name, const std::string& kind, bool required = true) {
  return {{"name", name}, {"kind", kind}, {"required", required}, {"help", ""}};
}

Json text(const std::string& name, const std::string& value) {
  return {{"name", name}, {"type", "text"}, {"default", value}, {"help", ""}};
}

Json integer(const std::string& name, int value) {
  return {{"name", name}, {"type", "integer"}, {"default", value}, {"help", ""}};
}

Json tool(const std::string& name, Json inputs, Json outputs, Json parameters) {
  return {{"tool", name},     {"summary", ""},      {"execution_path", ""},
          {"inputs", inputs}, {"outputs", outputs}, {"parameters", parameters}};
}

class SweepTest : public testing::Test, public BuildObserver {
 protected:
  SweepTest() {
    recipe_ = Json::parse(R"({
      "asset": { "mesh": { "kind": "mesh", "endings": [".obj"] },
                 "material": { "kind": "material", "required": false, "endings": [] },
                 "environment": { "kind": "image", "required": false, "endings": [".hdr"] } },
      "stages": {
        "simplify": { "inputs": { "mesh": "asset.mesh" }, "outputs": { "simplified": "mesh.ply" } },
        "transfer": { "inputs": { "mesh": "simplify.simplified" }, "outputs": { "transfer": "t.safetensors" } },
        "pack": { "inputs": { "transfer": "transfer.transfer" }, "outputs": { "pack": "{asset}.glb" },
                  "parameters": { "name": "{asset}" } },
        "frame": { "tool": "player", "inputs": { "pack": "pack.pack", "environment": "asset.environment" },
                   "outputs": { "image": "frame.png" } }
      },
      "deliver": { "pack": "pack.pack", "frame": "frame.image" },
      "report": {
        "pack": "pack.pack", "frame": "frame", "vary": ["transfer.order=2..3"],
        "frame_parameters": { "width": 64 },
        "cameras": { "front": { "yaw_deg": 25 }, "back": { "yaw_deg": 200 } },
        "reference": { "tool": "reference", "outputs": { "image": "reference.exr" },
                       "inputs": { "mesh": "simplify.simplified", "material": "asset.material",
                                   "environment": "view.environment", "framing": "truth.image" } },
        "comparison": { "tool": "judge", "outputs": { "figures": "figures.json" } },
        "truth": { "set": { "simplify": { "triangles": 1000 } }, "reference": { "transport": "full" } },
        "chain": [
          { "cause": "simplification", "reference": { "transport": { "same_as": "transfer.transport" } } },
          { "cause": "directions", "set": { "transfer": { "directions": 99 } } },
          { "cause": "storage" }
        ]
      }
    })");
    const auto joined = [](const char* output) {
      return [output](const auto& inputs, const Json& parameters) {
        std::string made = parameters.dump();
        for (const auto& [name, content] : inputs) made += " " + content;
        return std::map<std::string, std::string>{{output, made}};
      };
    };
    Json turn = integer("turn", 0);
    turn["changes_object"] = true;
    auto& runner = workshop_.runner;
    runner.install("simplify", {tool("simplify", {port("mesh", "mesh")}, {port("simplified", "mesh")},
                                     {integer("triangles", 100), turn}),
                                joined("simplified")});
    runner.install("transfer",
                   {tool("transfer", {port("mesh", "mesh")}, {port("transfer", "tensors")},
                         {integer("order", 5), integer("directions", 8), text("transport", "all")}),
                    [joined](const auto& inputs, const Json& parameters) {
                      if (parameters.at("order") == 9) throw badInput({"mesh", "", ""}, "is too much");
                      return joined("transfer")(inputs, parameters);
                    }});
    runner.install("pack",
                   {tool("pack", {port("transfer", "tensors")}, {port("pack", "pack")}, {text("name", "")}),
                    joined("pack")});
    runner.install("player", {tool("player", {port("pack", "pack"), port("environment", "image", false)},
                                   {port("image", "image")}, {integer("width", 640)}),
                              joined("image"),
                              {{"frame_ms", 4}}});
    runner.install(
        "reference",
        {tool("reference",
              {port("mesh", "mesh"), port("material", "material", false), port("table", "tensors", false),
               port("environment", "image", false), port("framing", "image", false)},
              {port("image", "image")},
              {integer("width", 640), integer("yaw_deg", 0), text("transport", "full")}),
         joined("image")});
    runner.install("judge", {tool("judge", {port("variants", "report_plan")},
                                  {port("page", "page", false), port("figures", "report")}, {}),
                             joined("figures")});
  }

  Sweep plan(const SweepOptions& options = {}) {
    workshop_.disk.write("recipes/prt.json", recipe_.dump());
    recipes_.emplace("recipes", workshop_.disk);  // reads a recipe once
    Problems problems;
    const std::vector<Asset> assets =
        findAssets({"assets/cube"}, "data", *recipes_, workshop_.disk, problems);
    std::optional<Sweep> sweep;
    problems.attempt([&] { sweep = planSweep(assets.at(0), *recipes_, tools_, options, problems); });
    problems.throwIfAny();
    return std::move(*sweep);
  }

  Json reportPlanOf(const Sweep& sweep) {
    Cache cache("out/.cache", workshop_.disk, memo_);
    OutputFolder out("out/cube/sweep", sweep.graph, workshop_.disk, memo_);
    const std::vector<PastRecord> past(sweep.graph.assets.size());
    const BuildResult result =
        Build({sweep.graph, tools_, cache, out, memo_, workshop_.disk, workshop_.runner, *this}, past,
              {.jobs = 1, .cores = 1})
            .run();
    return reportPlan("cube", sweep, result.outcomes, memo_);
  }

  std::size_t count(const Sweep& sweep, const std::string& tool_name) const {
    return static_cast<std::size_t>(std::count_if(sweep.graph.tasks.begin(), sweep.graph.tasks.end(),
                                                  [&](const Task& task) { return task.tool == tool_name; }));
  }

  void started(TaskIndex) override {}
  void progressed(TaskIndex, const ToolProgress&) override {}
  void said(TaskIndex, const std::string&) override {}
  void settled(TaskIndex, const Outcome&) override {}

  Workshop workshop_;
  Json recipe_;
  Memo memo_{"out/.cache/memo.json", workshop_.disk};
  std::optional<RecipeBook> recipes_;
  Toolbox tools_{"tools", "processor", workshop_.disk, workshop_.runner, memo_};
};

TEST_F(SweepTest, WhatVariantsShareIsPlannedOnce) {
  const Sweep sweep = plan();
  ASSERT_EQ(sweep.variants.size(), 2u);
  // Truth, the variants' simplification, and of each order the variant (equal to its storage link but for
  // what it delivers) and the link with more directions.
  EXPECT_EQ(sweep.graph.assets.size(), 2u + 2 * 3);
  // Two cameras: the truth, and one simplified scene for both orders.
  EXPECT_EQ(count(sweep, "reference"), 4u);
  EXPECT_EQ(sweep.variants[0].chain[0].references, sweep.variants[1].chain[0].references);
  EXPECT_NE(sweep.variants[0].chain[1].pack, sweep.variants[1].chain[1].pack);
}

TEST_F(SweepTest, LinksDifferFromTheVariantInOneRespect) {
  const Sweep sweep = plan();
  const auto transferOf = [&](TaskIndex pack) -> const Json& {
    return sweep.graph.tasks[*sweep.graph.tasks[pack].inputs.at("transfer").maker].parameters;
  };
  const SweptVariant& variant = sweep.variants[1];
  ASSERT_EQ(variant.chain.size(), 3u);
  EXPECT_EQ(transferOf(variant.pack).at("order"), 3);
  EXPECT_EQ(transferOf(variant.chain[1].pack).at("order"), 3);
  EXPECT_EQ(transferOf(variant.chain[1].pack).at("directions"), 99);
  EXPECT_EQ(transferOf(variant.chain[2].pack), transferOf(variant.pack));
  const Task& traced = sweep.graph.tasks[variant.chain[0].references[0]];
  EXPECT_EQ(traced.parameters.at("transport"), "all") << "the variant's";
  EXPECT_EQ(sweep.graph.tasks[*traced.inputs.at("mesh").maker].stage, "simplify");
  EXPECT_EQ(traced.inputs.at("framing").maker, sweep.truths[0]) << "seen by the truth's camera";
  const Task& truth = sweep.graph.tasks[sweep.truths[0]];
  EXPECT_EQ(truth.inputs.count("framing"), 0u);
  EXPECT_EQ(truth.parameters.at("transport"), "full");
  EXPECT_EQ(truth.parameters.at("width"), 64);
}

TEST_F(SweepTest, ViewsAreAllLightsSeenByAllCameras) {
  workshop_.disk.write("assets/cube/asset.json",
                       Json({{"mesh", "cube.obj"},
                             {"report",
                              {{"lights", {{"sky", "sky.hdr"}, {"lamps", "rig.json"}}},
                               {"cameras", {{"top", {{"yaw_deg", 90}}}}}}}})
                           .dump());
  workshop_.disk.write("assets/cube/rig.json", "{}");
  const Sweep sweep = plan();
  ASSERT_EQ(sweep.views.size(), 2u);
  EXPECT_EQ(sweep.views[0].name, "lamps-top");
  EXPECT_EQ(sweep.views[0].lights.filename(), "rig.json");
  EXPECT_TRUE(sweep.views[0].environment.empty());
  EXPECT_EQ(sweep.views[1].environment.filename(), "sky.hdr");
  EXPECT_EQ(sweep.views[1].frame, Json({{"width", 64}, {"yaw_deg", 90}}));
}

TEST_F(SweepTest, AnAssetMayTakeALaterLinkForItsTruth) {
  const auto asset = [&](const char* cause) {
    workshop_.disk.write("assets/cube/asset.json",
                         Json({{"mesh", "cube.obj"}, {"report", {{"truth", cause}}}}).dump());
  };
  asset("simplification");
  const Sweep sweep = plan();
  EXPECT_EQ(sweep.graph.tasks[sweep.truths[0]].parameters.at("transport"), "all") << "the link's";
  ASSERT_EQ(sweep.variants[0].chain.size(), 2U);
  EXPECT_EQ(sweep.variants[0].chain[0].cause, "directions");
  EXPECT_EQ(count(sweep, "reference"), 2U) << "the truth alone";
  for (const char* other : {"storage", "weather"}) {  // no path-traced one
    asset(other);
    try {
      plan();
      ADD_FAILURE() << "accepted \"" << other << '"';
    } catch (const ProblemsFound& found) {
      EXPECT_THAT(found.what(), HasSubstr(other));
    }
  }
}

TEST_F(SweepTest, VaryAndSettingsOfTheCommandLineWin) {
  const Sweep sweep =
      plan({.vary = {"transfer.directions=1,2,3"}, .settings = {parseSetting("transfer.order=7")}});
  ASSERT_EQ(sweep.variants.size(), 3u);
  const Task& pack = sweep.graph.tasks[sweep.variants[2].pack];
  const Json& parameters = sweep.graph.tasks[*pack.inputs.at("transfer").maker].parameters;
  EXPECT_EQ(parameters.at("directions"), 3);
  EXPECT_EQ(parameters.at("order"), 7);
}

// Ground truth is made of what the asset is, by wires that the recipe has; nothing is baked for it.
TEST_F(SweepTest, TruthTakesTheMeshAndTheMaterialAndALinkMayTakeMore) {
  workshop_.disk.write("assets/cube/asset.json",
                       Json({{"mesh", "cube.obj"}, {"material", {{"albedo", {0.5, 0.5, 0.5}}}}}).dump());
  recipe_["report"]["chain"][0]["inputs"]["table"] = "transfer.transfer";
  const Sweep sweep = plan();
  const Task& truth = sweep.graph.tasks[sweep.truths[0]];
  EXPECT_EQ(truth.inputs.at("material").value.at("material").at("albedo"), Json({0.5, 0.5, 0.5}));
  EXPECT_EQ(truth.inputs.count("table"), 0u);
  for (const Task& task : sweep.graph.tasks)
    if (task.asset == truth.asset && task.stage == "transfer") {
      EXPECT_EQ(task.left_out, kNotNeeded);
    }
  const Task& linked = sweep.graph.tasks[sweep.variants[1].chain[0].references[0]];
  const Task& transfer = sweep.graph.tasks[*linked.inputs.at("table").maker];
  EXPECT_EQ(transfer.parameters.at("order"), 3);
  EXPECT_EQ(transfer.left_out, "");
}

TEST_F(SweepTest, AnObjectThatVariesIsRefused) {
  try {
    plan({.vary = {"simplify.turn=1,2"}});
    FAIL() << "accepted";
  } catch (const ProblemsFound& found) {
    EXPECT_EQ(found.errors().front().status(), ExitStatus::kUsage);
    EXPECT_THAT(found.what(), HasSubstr("simplify.turn changes the object itself"));
  }
}

TEST_F(SweepTest, MistakesInWhatVariesAreToldBeforeAnythingRuns) {
  for (const char* vary : {"transfer.ordr=1", "transfr.order=1", "transfer.order=many"})
    EXPECT_THROW(plan({.vary = {vary}}), ProblemsFound) << vary;
}

TEST_F(SweepTest, ARecipeThatDoesNotSayHowIsRefused) {
  recipe_.erase("report");
  EXPECT_THROW(plan(), ProblemsFound);
}

TEST_F(SweepTest, TheRecipeNamesWhatComparesItsPacks) {
  const Comparison comparison = plan().comparison;
  EXPECT_EQ(comparison.tool, "judge");
  EXPECT_EQ(comparison.plan_input, "variants");
  EXPECT_EQ(comparison.figures_output, "figures");
  EXPECT_EQ(comparison.files.at("figures"), "figures.json");
  const auto problemsOfPlan = [&] {
    try {
      plan();
    } catch (const ProblemsFound& found) {
      return std::string(found.what());
    }
    return std::string("accepted");
  };
  const auto mistake = [&](const Json& wrong) {
    recipe_["report"]["comparison"] = wrong;
    return problemsOfPlan();
  };
  EXPECT_THAT(mistake({{"tool", "player"}, {"outputs", {{"image", "a.png"}}}}),
              HasSubstr("/comparison/tool"));
  EXPECT_THAT(mistake({{"tool", "judge"}, {"outputs", {{"figurs", "a.json"}}}}),
              HasSubstr("/outputs/figurs"));
  EXPECT_THAT(mistake({{"tool", "judge"}, {"outputs", {{"page", "a.html"}}}}),
              HasSubstr("the figures go nowhere"));
  recipe_["report"].erase("comparison");
  EXPECT_THAT(problemsOfPlan(), HasSubstr("does not say what compares its packs"));
}

TEST_F(SweepTest, ThePlanNamesEveryPictureAndWhatItCost) {
  const Json plan_json = reportPlanOf(plan());
  ASSERT_EQ(plan_json.at("variants").size(), 2u);
  const Json& variant = plan_json.at("variants")[0];
  EXPECT_EQ(variant.at("name"), "order=2");
  EXPECT_EQ(variant.at("parameters"), Json({{"transfer.order", 2}}));
  EXPECT_THAT(variant.at("pack").at("path").get<std::string>(), HasSubstr("cube.glb"));
  EXPECT_FALSE(variant.at("pack").at("hash").get<std::string>().empty());
  std::vector<std::string> stages, causes;
  for (const Json& stage : variant.at("stages")) stages.push_back(stage.at("stage"));
  for (const Json& link : variant.at("chain")) causes.push_back(link.at("cause"));
  EXPECT_THAT(stages, ElementsAre("simplify", "transfer", "pack"));
  EXPECT_THAT(causes, ElementsAre("simplification", "directions", "storage"));
  EXPECT_EQ(variant.at("chain")[0].at("references").size(), 2u);
  EXPECT_EQ(variant.at("player").at("frame_ms"), 4);
  ASSERT_EQ(plan_json.at("views").size(), 2u);
  EXPECT_THAT(plan_json.at("views")[0].at("reference").at("path").get<std::string>(),
              HasSubstr("reference.exr"));
}

TEST_F(SweepTest, MistakesInTheRecipesChainAreTold) {
  for (const char* link : {"transfer.transprt", "transfr.transport", "transport", ""}) {
    recipe_["report"]["chain"][0]["reference"]["transport"]["same_as"] = link;
    try {
      plan();
      ADD_FAILURE() << "accepted \"" << link << '"';
    } catch (const ProblemsFound& found) {
      EXPECT_THAT(found.what(), HasSubstr("there is no parameter"));
    }
  }
}

TEST_F(SweepTest, AChainWithAFailedLinkTellsNoCauses) {
  recipe_["report"]["chain"][1]["set"]["transfer"]["order"] = 9;  // which fails
  const Json plan_json = reportPlanOf(plan());
  ASSERT_EQ(plan_json.at("variants").size(), 2u);
  EXPECT_TRUE(plan_json.at("variants")[0].at("chain").empty());
}

TEST_F(SweepTest, AVariantThatFailsIsListedAndTheOthersGoOn) {
  const Json plan_json = reportPlanOf(plan({.vary = {"transfer.order=2,9"}}));
  ASSERT_EQ(plan_json.at("variants").size(), 1u);
  ASSERT_EQ(plan_json.at("failed").size(), 1u);
  EXPECT_EQ(plan_json.at("failed")[0],
            Json({{"name", "order=9"}, {"stage", "transfer"}, {"reason", "is too much"}}));
}

// Its error is that of the pack against the same with everything kept.
TEST_F(SweepTest, AStageThatIsLeftOutIsInTheReportAndInWhatItIsMeasuredAgainst) {
  const auto tool_with = [&](const std::string& name, Json inputs, Json outputs, const Json& stats) {
    const std::string output = outputs.empty() ? "" : outputs[0].at("name").get<std::string>();
    workshop_.runner.install(name,
                             {tool(name, std::move(inputs), std::move(outputs), {integer("order", 5)}),
                              [output](const auto& inputs_given, const Json&) {
                                std::map<std::string, std::string> made;
                                for (const auto& [port_name, content] : inputs_given)
                                  if (!output.empty()) made[output] += port_name + " " + content;
                                return made;
                              },
                              stats},
                             "2");
  };
  const Json mesh = port("mesh", "mesh");
  tool_with("survey", Json::array({mesh}), Json::array(), {{"roughness", 0.5}});
  tool_with("detail", Json::array({mesh}), Json::array({port("detail", "tensors")}), Json::object());
  tool_with("transfer", {mesh, port("detail", "tensors", false)}, Json::array({port("transfer", "tensors")}),
            Json::object());
  Json& stages = recipe_["stages"];
  stages["survey"]["inputs"]["mesh"] = stages["detail"]["inputs"]["mesh"] = "simplify.simplified";
  stages["detail"]["outputs"]["detail"] = "detail.safetensors";
  stages["detail"]["leave_out"] = Json::parse(
      R"([ { "what": "small detail", "figure": "survey.roughness", "at_most": 0.75, "omit": true } ])");
  stages["transfer"]["inputs"]["detail"] = "detail.detail";
  recipe_["report"]["chain"].erase(recipe_["report"]["chain"].begin(),
                                   recipe_["report"]["chain"].begin() + 2);

  const Json variant = reportPlanOf(plan()).at("variants").at(0);
  ASSERT_EQ(variant.at("left_out").size(), 1u);
  EXPECT_EQ(variant.at("left_out")[0], Json({{"what", "small detail"},
                                             {"stage", "detail"},
                                             {"figure", "survey.roughness"},
                                             {"value", 0.5},
                                             {"threshold", 0.75},
                                             {"error", 0.5}}));
  std::vector<std::string> names;
  for (const Json& stage : variant.at("stages")) names.push_back(stage.at("stage"));
  EXPECT_THAT(names, testing::UnorderedElementsAre("simplify", "survey", "transfer", "pack"));
  ASSERT_EQ(variant.at("chain").size(), 2u);
  EXPECT_EQ(variant.at("chain")[1].at("cause"), "left_out");
  EXPECT_EQ(variant.at("chain")[1].at("pack"), variant.at("pack"));
  EXPECT_NE(variant.at("chain")[0].at("pack").at("hash"), variant.at("pack").at("hash")) << "with the detail";
}

}  // namespace
}  // namespace bakelight::pipeline
