// Rules by which measured figures leave out whole stages, and what is made for them only.
#include <algorithm>
#include <sstream>

#include "pipeline/console.h"
#include "pipeline/graph_export.h"
#include "workshop.h"

namespace bakelight::pipeline {
namespace {

using Json = nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::UnorderedElementsAre;

Json port(const std::string& name, const std::string& kind, bool required = true) {
  return {{"name", name}, {"kind", kind}, {"required", required}, {"help", ""}};
}

// An id map is made of a mesh in two steps, and transfer can do without it.
class Omit : public testing::Test {
 protected:
  Omit() {
    recipe_ = Json::parse(R"({
      "asset": { "mesh": { "kind": "mesh", "endings": [".obj"] } },
      "stages": {
        "own_uv": { "tool": "check", "inputs": { "mesh": "asset.mesh" } },
        "mesomesh": { "inputs": { "mesh": "asset.mesh" }, "outputs": { "made": "meso.ply" } },
        "synthesis": { "inputs": { "mesh": "mesomesh.made" }, "outputs": { "made": "patches.ply" } },
        "idmap": {
          "inputs": { "mesh": "synthesis.made" }, "outputs": { "made": "id_map.exr" },
          "leave_out": [ { "what": "id map", "figure": "own_uv.shortcomings", "at_most": 0, "error": "own_uv.stretch", "omit": true } ]
        },
        "transfer": {
          "inputs": { "mesh": "asset.mesh", "ids": "idmap.made" }, "outputs": { "made": "transfer.ply" }
        }
      },
      "deliver": { "transfer": "transfer.made", "id_map": "idmap.made" }
    })");
    measure(0);
    for (const char* tool : {"mesomesh", "synthesis", "idmap", "picture"})
      install(tool, {port("mesh", "mesh"), port("texture", "image", false)});
    install("transfer", {port("mesh", "mesh"), port("ids", "mesh", false)});
    workshop_.settings = {.jobs = 4, .cores = 4};
  }

  // What `tool` makes is its name and what it is given: "idmap(mesh cube)".
  void install(const std::string& tool, const Json& inputs,
               Json outputs = Json::array({port("made", "mesh")}), Json stats = {}) {
    workshop_.runner.install(tool,
                             {{{"tool", tool},
                               {"summary", ""},
                               {"execution_path", ""},
                               {"inputs", inputs},
                               {"outputs", outputs},
                               {"parameters", Json::array()}},
                              [this, tool, none = outputs.empty()](const auto& given, const Json&) {
                                if (tool == failing_) throw badInput({"mesh", "", ""}, "is too much");
                                std::string made = tool + "(";
                                for (const auto& [name, content] : given) made += name + " " + content + ",";
                                made.back() = ')';
                                return none ? std::map<std::string, std::string>()
                                            : std::map<std::string, std::string>{{"made", made}};
                              },
                              std::move(stats)},
                             std::to_string(++revision_));
  }

  void measure(int shortcomings) {
    install("check", Json::array({port("mesh", "mesh")}), Json::array(),
            {{"shortcomings", shortcomings}, {"stretch", 0.25}});
  }

  void writeRecipe() { workshop_.disk.write("recipes/prt.json", recipe_.dump()); }

  // The tools that ran.
  std::vector<std::string> run(int exit_status = 0) {
    writeRecipe();
    workshop_.toolsStarted();
    EXPECT_EQ(workshop_.run().exitStatus(), exit_status);
    return workshop_.toolsStarted();
  }

  std::map<std::string, std::string> explain() {
    writeRecipe();
    return workshop_.explain();
  }

  std::string transfer() { return workshop_.disk.read("out/cube/transfer.ply"); }
  Json stage(const std::string& name) { return workshop_.record().at("stages").at(name); }
  std::string outcome(const std::string& name) {
    return stage(name).at("status").get<std::string>() + ": " + stage(name).at("reason").get<std::string>();
  }
  std::vector<std::string> filesOf(const std::string& name) {
    return workshop_.disk.pathsContaining("out/cube/" + name);
  }

  Workshop workshop_;
  Json recipe_;
  std::string failing_;  // tool
  int revision_ = 0;

  const std::string with_id_map_ =
      "transfer(ids idmap(mesh synthesis(mesh mesomesh(mesh eight corners))),mesh eight corners)";
  const std::string without_id_map_ = "transfer(mesh eight corners)";
  const std::string why_ = "id map: own_uv.shortcomings is 0.0, at most 0.0";
};

TEST_F(Omit, AStageAndWhatOnlyItNeedsDoNotRunAndItsUserDoesWithout) {
  EXPECT_THAT(run(), UnorderedElementsAre("check", "transfer"));
  EXPECT_EQ(transfer(), without_id_map_);
  EXPECT_FALSE(stage("transfer").at("ingredients").at("inputs").contains("ids"));
  EXPECT_EQ(outcome("idmap"), "left-out: " + why_);
  EXPECT_EQ(outcome("synthesis"), "left-out: only idmap would need it");
  EXPECT_EQ(outcome("mesomesh"), "left-out: only synthesis would need it");
  EXPECT_EQ(stage("idmap").at("left_out"), Json::array({{{"what", "id map"},
                                                         {"figure", "own_uv.shortcomings"},
                                                         {"value", 0},
                                                         {"threshold", 0},
                                                         {"error", 0.25}}}));
  EXPECT_FALSE(stage("idmap").contains("outputs"));
  EXPECT_THAT(filesOf("id_map.exr"), IsEmpty());
}

TEST_F(Omit, AboveTheThresholdEverythingIsMade) {
  measure(1);
  EXPECT_THAT(run(), UnorderedElementsAre("check", "mesomesh", "synthesis", "idmap", "transfer"));
  EXPECT_EQ(transfer(), with_id_map_);
  EXPECT_FALSE(stage("idmap").contains("left_out"));
  EXPECT_FALSE(filesOf("id_map.exr").empty());
}

TEST_F(Omit, AnAssetOrTheCommandLineKeepsTheStage) {
  workshop_.options.keep_all = true;
  EXPECT_THAT(run(), Not(testing::Contains("check")));
  EXPECT_EQ(transfer(), with_id_map_);
  workshop_.options.keep_all = false;
  run();
  EXPECT_EQ(transfer(), without_id_map_);
  for (const Json& keep : {Json(false), Json{{"idmap", false}}}) {
    workshop_.writeAssetFile("cube", {{"mesh", "cube.obj"}, {"leave_out", keep}});
    run();
    EXPECT_EQ(transfer(), with_id_map_) << keep;
  }
  workshop_.writeAssetFile("cube",
                           {{"mesh", "cube.obj"}, {"leave_out", {{"idmap", true}, {"transfer", false}}}});
  run();
  EXPECT_EQ(transfer(), without_id_map_);
}

TEST_F(Omit, AnAssetThatKeepsAStageThatIsNotThereIsTold) {
  writeRecipe();
  workshop_.writeAssetFile("cube", {{"mesh", "cube.obj"}, {"leave_out", {{"idmapp", false}}}});
  EXPECT_THAT(workshop_.problems(),
              ElementsAre(AllOf(HasSubstr("/leave_out/idmapp"), HasSubstr("unknown key \"idmapp\""),
                                HasSubstr("write \"idmap\""))));
}

TEST_F(Omit, WhatSomethingElseNeedsRuns) {
  recipe_["deliver"]["meso"] = "mesomesh.made";
  EXPECT_THAT(run(), UnorderedElementsAre("check", "mesomesh", "transfer"));
  EXPECT_EQ(outcome("synthesis"), "left-out: only idmap would need it");
}

TEST_F(Omit, WhatIsNeededForSeveralThingsNamesThemAll) {
  recipe_["stages"]["other"] = recipe_["stages"]["idmap"];
  recipe_["stages"]["other"]["tool"] = "idmap";
  recipe_["stages"]["other"]["outputs"]["made"] = "other.exr";
  recipe_["deliver"]["other"] = "other.made";
  EXPECT_THAT(run(), UnorderedElementsAre("check", "transfer"));
  EXPECT_EQ(outcome("synthesis"), "left-out: only idmap and other would need it");
}

// The figures of rules that only change parameters are not asked for before the stage is kept.
TEST_F(Omit, OtherRulesAreJudgedOnceTheStageIsKept) {
  recipe_["stages"]["survey"] = {{"tool", "check"}, {"inputs", {{"mesh", "mesomesh.made"}}}};
  recipe_["stages"]["idmap"]["leave_out"].push_back({{"what", "detail"},
                                                     {"figure", "survey.shortcomings"},
                                                     {"at_most", 7},
                                                     {"set", {{"detail", {{"fine", "coarse"}}}}}});
  Json description = Json::parse(workshop_.runner.capture({"tools/idmap"}).output);
  description["parameters"] = {{{"name", "detail"}, {"type", "text"}, {"default", "fine"}, {"help", ""}}};
  workshop_.runner.install("idmap",
                           {description, [](const auto&, const Json& parameters) {
                              return std::map<std::string, std::string>{{"made", parameters.at("detail")}};
                            }});
  EXPECT_THAT(run(), UnorderedElementsAre("check", "transfer"));
  EXPECT_EQ(outcome("survey"), "left-out: only idmap would need it");
  measure(3);
  run();
  EXPECT_EQ(workshop_.disk.read("out/cube/id_map.exr"), "coarse");
  EXPECT_EQ(stage("idmap").at("left_out").size(), 1u);
  EXPECT_EQ(stage("idmap").at("left_out")[0].at("what"), "detail");
}

TEST_F(Omit, AUserThatRequiresTheInputIsRefusedUnlessItGoesWithIt) {
  recipe_["stages"]["picture"] = {{"inputs", {{"mesh", "idmap.made"}}},
                                  {"outputs", {{"made", "id_map.png"}}}};
  recipe_["deliver"]["picture"] = "picture.made";
  writeRecipe();
  EXPECT_THAT(
      workshop_.problems(),
      ElementsAre(AllOf(HasSubstr("recipes/prt.json"), HasSubstr("/stages/picture/inputs/mesh"),
                        HasSubstr("the stage idmap may be left out"), HasSubstr("tool picture requires"))));
  workshop_.options.keep_all = true;
  EXPECT_THAT(workshop_.problems(), IsEmpty()) << "nothing is left out";
  workshop_.options.keep_all = false;

  recipe_["stages"]["picture"]["leave_out"] = recipe_["stages"]["idmap"]["leave_out"];
  EXPECT_THAT(run(), UnorderedElementsAre("check", "transfer"));
  EXPECT_EQ(outcome("picture"), "left-out: " + why_);
  recipe_["stages"]["picture"]["leave_out"][0]["at_most"] = -1;
  writeRecipe();
  EXPECT_EQ(workshop_.problems().size(), 1u) << "idmap may be left out without the picture";
}

TEST_F(Omit, MistakesInRulesAreToldWithTheirPlace) {
  const auto problemsWith = [&](const std::string& pointer, const Json& value) {
    Json broken = recipe_;
    broken[Json::json_pointer(pointer)] = value;
    workshop_.disk.write("recipes/prt.json", broken.dump());
    const std::vector<std::string> problems = workshop_.problems();
    return problems.empty() ? "" : problems.front();
  };
  const std::string rule = "/stages/idmap/leave_out/0";
  EXPECT_EQ(problemsWith(rule + "/at_most", 1), "") << "no mistake";
  EXPECT_THAT(problemsWith(rule + "/omit", false),
              AllOf(HasSubstr(rule + "/set"), HasSubstr("changes nothing")));
  EXPECT_THAT(problemsWith(rule + "/omit", "yes"), HasSubstr(rule + "/omit"));
  EXPECT_THAT(problemsWith(rule + "/set", {{"detail", {{"fine", "coarse"}}}}),
              AllOf(HasSubstr(rule + "/set"), HasSubstr("nothing to set")));
  Json second = recipe_["stages"]["idmap"]["leave_out"];
  second[0]["figure"] = "idmap.size";
  EXPECT_THAT(
      problemsWith("/stages/transfer/leave_out", second),
      AllOf(HasSubstr("/stages/transfer/leave_out/0/figure"), HasSubstr("idmap may be left out as a whole")));
}

TEST_F(Omit, AFigureStageWhoseToolIsMissingIsToldAsSuch) {
  recipe_["stages"]["own_uv"]["tool"] = "missing";
  writeRecipe();
  EXPECT_THAT(workshop_.problems(), ElementsAre(HasSubstr("/stages/own_uv/tool")));
}

TEST_F(Omit, ExplainedBeforeAndAfterTheFigureIsKnown) {
  auto told = explain();
  EXPECT_EQ(told["own_uv"], "would run: never run");
  EXPECT_EQ(told["idmap"], "depends: on what own_uv will tell");
  EXPECT_EQ(told["synthesis"], "depends: on whether idmap will need it");
  EXPECT_EQ(told["mesomesh"], "depends: on whether synthesis will need it");
  EXPECT_EQ(told["transfer"], "depends: on what idmap will make");
  run();
  told = explain();
  EXPECT_EQ(told["idmap"], "left out: " + why_);
  EXPECT_EQ(told["synthesis"], "left out: only idmap would need it");
  EXPECT_EQ(told["transfer"], "up to date");
  EXPECT_THAT(run(), IsEmpty());

  recipe_["stages"]["idmap"]["leave_out"][0]["at_most"] = -1;
  told = explain();
  EXPECT_EQ(told["mesomesh"], "would run: left out last time");
  EXPECT_EQ(told["idmap"], "depends: on what synthesis will make");
  EXPECT_THAT(run(), UnorderedElementsAre("mesomesh", "synthesis", "idmap", "transfer"));
  EXPECT_EQ(outcome("transfer"), "ran: input ids is new (idmap made a different id_map.exr)");
}

TEST_F(Omit, FilesOfAnEarlierRunAreRemovedAndComeBackFromTheCache) {
  workshop_.options.keep_all = true;
  run();
  workshop_.disk.write("out/cube/idmap/notes.txt", "mine");
  workshop_.options.keep_all = false;
  run();  // which makes the figure, too
  EXPECT_THAT(filesOf("id_map.exr"), IsEmpty());
  EXPECT_THAT(filesOf("idmap/"), ElementsAre("out/cube/idmap/notes.txt"));
  EXPECT_THAT(filesOf("mesomesh"), IsEmpty());
  EXPECT_THAT(filesOf("synthesis"), IsEmpty());

  workshop_.options.keep_all = true;
  EXPECT_EQ(explain()["idmap"], "would come from the cache: left out last time");
  EXPECT_THAT(run(), IsEmpty());
  EXPECT_FALSE(filesOf("id_map.exr").empty());
  EXPECT_FALSE(stage("idmap").contains("left_out"));

  workshop_.options.keep_all = false;
  auto told = explain();
  EXPECT_EQ(told["idmap"], "would be left out: " + why_);
  EXPECT_EQ(told["mesomesh"], "would be left out: only synthesis would need it");
  EXPECT_EQ(told["transfer"], "would come from the cache: input ids is no longer given");
}

TEST_F(Omit, WithoutTheFigureNothingIsDecided) {
  failing_ = "check";
  EXPECT_THAT(run(2), ElementsAre("check"));
  EXPECT_EQ(outcome("idmap"), "not-run: own_uv failed");
  EXPECT_EQ(outcome("synthesis"), "not-run: own_uv failed");
  EXPECT_EQ(outcome("mesomesh"), "not-run: own_uv failed");
  EXPECT_EQ(outcome("transfer"), "not-run: own_uv failed");
}

// Whichever of the two ends first.
TEST_F(Omit, AFailureOfWhatItWouldHaveBeenMadeFromDoesNotMatter) {
  recipe_["deliver"]["meso"] = "mesomesh.made";
  failing_ = "mesomesh";
  for (const bool last_first : {false, true}) {
    workshop_.runner.last_started_ends_first = last_first;
    workshop_.disk.removeAll("out");
    EXPECT_THAT(run(2), UnorderedElementsAre("check", "mesomesh", "transfer"));
    EXPECT_EQ(outcome("idmap"), "left-out: " + why_);
    EXPECT_EQ(transfer(), without_id_map_);
  }
  measure(1);
  for (const bool last_first : {false, true}) {
    workshop_.runner.last_started_ends_first = last_first;
    workshop_.disk.removeAll("out");
    EXPECT_THAT(run(2), UnorderedElementsAre("check", "mesomesh"));
    EXPECT_EQ(outcome("idmap"), "not-run: mesomesh failed");
    EXPECT_EQ(outcome("transfer"), "not-run: mesomesh failed");
  }
}

TEST_F(Omit, AnInterruptedRunGoesOn) {
  writeRecipe();
  workshop_.settings.jobs = 1;
  workshop_.runner.interrupt_after = 1;  // while the figure is measured
  EXPECT_EQ(workshop_.run().exitStatus(), 130);
  EXPECT_EQ(outcome("mesomesh"), "not-run: interrupted");
  EXPECT_EQ(outcome("idmap"), "not-run: interrupted");
  workshop_.runner.forgetInterruption();
  workshop_.runner.interrupt_after = 3;
  workshop_.toolsStarted();
  measure(1);
  EXPECT_EQ(workshop_.run().exitStatus(), 130);
  EXPECT_THAT(workshop_.toolsStarted(), ElementsAre("check", "mesomesh", "synthesis"));
  EXPECT_EQ(outcome("synthesis"), "not-run: interrupted");
  workshop_.runner.forgetInterruption();
  EXPECT_THAT(run(), ElementsAre("synthesis", "idmap", "transfer"));
}

TEST_F(Omit, TheConsoleTellsWhatIsNotDeliveredEachTimeAndTheRestOnce) {
  writeRecipe();
  const Graph graph = workshop_.graph();
  const auto told = [&] {
    const BuildResult result = workshop_.run();
    std::ostringstream lines, errors;
    Console console(graph, lines, errors, false);
    for (TaskIndex task = 0; task < graph.tasks.size(); ++task)
      if (result.outcomes[task].status == StageStatus::kLeftOut) console.settled(task, result.outcomes[task]);
    return lines.str();
  };
  const std::string undelivered = "left out (" + why_ + "); not delivered: id_map\n";
  const std::string first = told(), second = told();
  EXPECT_THAT(first, AllOf(HasSubstr("cube idmap"), HasSubstr(undelivered),
                           HasSubstr("left out (only synthesis would need it)\n")));
  EXPECT_THAT(second, AllOf(HasSubstr(undelivered), Not(HasSubstr("synthesis"))));
}

TEST_F(Omit, GraphsShowWhatMayBeLeftOut) {
  writeRecipe();
  const Graph graph = workshop_.graph();
  EXPECT_THAT(toText(graph), HasSubstr("-> id_map.exr (left out if own_uv.shortcomings at most 0.0)\n"));
  EXPECT_THAT(toDot(graph), AllOf(HasSubstr("\"cube idmap\" [label=\"idmap\", style=dotted]"),
                                  HasSubstr("\"cube own_uv\" -> \"cube idmap\" [style=dotted")));
  const Json json = toJson(graph);
  const auto idmap = std::find_if(json.at("stages").begin(), json.at("stages").end(),
                                  [](const Json& entry) { return entry.at("stage") == "idmap"; });
  ASSERT_NE(idmap, json.at("stages").end());
  EXPECT_EQ(idmap->at("left_out_if"), "own_uv.shortcomings at most 0.0");
}

}  // namespace
}  // namespace bakelight::pipeline
