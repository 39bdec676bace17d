// Rules by which measured figures leave things out, and parameters that follow those of another stage.
#include "pipeline/leave_out.h"

#include "workshop.h"

namespace bakelight::pipeline {
namespace {

using Json = nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

Json text(const std::string& name, const std::string& value, std::vector<std::string> choices) {
  return {{"name", name}, {"type", "text"}, {"default", value}, {"choices", choices}, {"help", ""}};
}

// The workshop with a survey, and a recipe whose transfer leaves out bounces where they add little.
class LeaveOut : public testing::Test {
 protected:
  LeaveOut() {
    recipe_ = Json::parse(R"({
      "asset": { "mesh": { "kind": "mesh", "endings": [".obj"] } },
      "stages": {
        "survey": { "inputs": { "mesh": "asset.mesh" }, "parameters": { "tint": { "same_as": "transfer.tint" } } },
        "transfer": {
          "inputs": { "mesh": "asset.mesh" }, "outputs": { "transfer": "transfer.safetensors" },
          "leave_out": [
            { "what": "all rays", "figure": "survey.concavity", "at_most": 0.001, "error": "survey.blocked",
              "set": { "transport": { "shadowed": "unshadowed", "interreflected": "unshadowed" } } },
            { "what": "bounces", "figure": "survey.bounces", "at_most": 0.01,
              "set": { "transport": { "interreflected": "shadowed" } } }
          ]
        }
      },
      "deliver": { "transfer": "transfer.transfer" }
    })");
    measure(0.5, 0.2, 0.3);
    const Json mesh = {{"name", "mesh"}, {"kind", "mesh"}, {"required", true}, {"help", ""}};
    const Json transfer = {{"name", "transfer"}, {"kind", "tensors"}, {"required", true}, {"help", ""}};
    workshop_.runner.install(
        "transfer", {{{"tool", "transfer"},
                      {"summary", ""},
                      {"execution_path", ""},
                      {"inputs", {mesh}},
                      {"outputs", {transfer}},
                      {"parameters",
                       {text("transport", "interreflected", {"unshadowed", "shadowed", "interreflected"}),
                        text("tint", "white", {"white", "red"})}}},
                     [](const auto&, const Json& parameters) {
                       return std::map<std::string, std::string>{{"transfer", parameters.at("transport")}};
                     }});
  }

  void measure(double concavity, double blocked, double bounces) {
    const Json mesh = {{"name", "mesh"}, {"kind", "mesh"}, {"required", true}, {"help", ""}};
    workshop_.runner.install("survey",
                             {{{"tool", "survey"},
                               {"summary", ""},
                               {"execution_path", ""},
                               {"inputs", {mesh}},
                               {"outputs", Json::array()},
                               {"parameters", {text("tint", "blue", {"white", "red", "blue"})}}},
                              [](const auto&, const Json&) { return std::map<std::string, std::string>{}; },
                              {{"concavity", concavity}, {"blocked", blocked}, {"bounces", bounces}}},
                             std::to_string(++revision_));
  }

  std::string baked() {
    workshop_.disk.write("recipes/prt.json", recipe_.dump());
    EXPECT_EQ(workshop_.run().exitStatus(), 0);
    return workshop_.disk.read("out/cube/transfer.safetensors");
  }

  Json omissions() { return workshop_.record().at("stages").at("transfer").value("left_out", Json::array()); }

  Workshop workshop_;
  Json recipe_;
  int revision_ = 0;
};

// A parameter that a figure settles: known only once its stage has run, weaker than what a person says.
TEST_F(LeaveOut, AFigureMaySettleAParameter) {
  Json& transfer = recipe_["stages"]["transfer"];
  transfer["leave_out"] = Json::array();
  transfer["parameters"]["strength"] = {{"figure", "survey.bounces"}};
  const Json mesh = {{"name", "mesh"}, {"kind", "mesh"}, {"required", true}, {"help", ""}};
  const Json output = {{"name", "transfer"}, {"kind", "tensors"}, {"required", true}, {"help", ""}};
  workshop_.runner.install(
      "transfer",
      {{{"tool", "transfer"},
        {"summary", ""},
        {"execution_path", ""},
        {"inputs", {mesh}},
        {"outputs", {output}},
        {"parameters",
         {{{"name", "strength"},
           {"type", "real"},
           {"default", 7.0},
           {"min", 0.0},
           {"max", 9.0},
           {"unit", ""},
           {"help", ""}},
          text("tint", "white", {"white", "red"})}}},
       [](const auto&, const Json& parameters) {
         return std::map<std::string, std::string>{{"transfer", parameters.at("strength").dump()}};
       }});
  EXPECT_EQ(baked(), "0.3");
  measure(0.5, 0.2, 0.25);
  EXPECT_EQ(baked(), "0.25");
  EXPECT_EQ(workshop_.record().at("stages").at("transfer").at("reason"), "strength changed from 0.3 to 0.25");
  workshop_.writeAssetFile("cube", {{"mesh", "cube.obj"}, {"stages", {{"transfer", {{"strength", 2}}}}}});
  EXPECT_EQ(baked(), "2.0");
  EXPECT_EQ(workshop_.record().at("stages").at("survey").at("status"), "left-out");

  recipe_["stages"]["transfer"]["parameters"]["strength"] = {{"figure", "suvey.bounces"}};
  workshop_.disk.write("recipes/prt.json", recipe_.dump());
  EXPECT_THAT(workshop_.problems(), ElementsAre(HasSubstr("/stages/transfer/parameters/strength/figure")));
}

TEST_F(LeaveOut, FiguresAboveTheThresholdsLeaveNothingOut) {
  EXPECT_EQ(baked(), "interreflected");
  EXPECT_TRUE(omissions().empty());
}

TEST_F(LeaveOut, AFigureAtTheThresholdLeavesOutAndIsWrittenDown) {
  measure(0.5, 0.2, 0.01);
  EXPECT_EQ(baked(), "shadowed");
  ASSERT_EQ(omissions().size(), 1u);
  EXPECT_EQ(omissions()[0], Json({{"what", "bounces"},
                                  {"figure", "survey.bounces"},
                                  {"value", 0.01},
                                  {"threshold", 0.01},
                                  {"error", 0.01}}));
}

TEST_F(LeaveOut, TheFirstRuleThatHoldsWinsAndNamesItsOwnError) {
  measure(0, 0.0002, 0.001);
  EXPECT_EQ(baked(), "unshadowed");
  ASSERT_EQ(omissions().size(), 1u) << "the second rule has nothing left to change";
  EXPECT_EQ(omissions()[0].at("what"), "all rays");
  EXPECT_EQ(omissions()[0].at("error"), 0.0002);
}

TEST_F(LeaveOut, WhatTheFiguresSayIsRememberedAlsoWhenNothingRuns) {
  measure(0, 0, 0);
  baked();
  workshop_.toolsStarted();
  EXPECT_EQ(baked(), "unshadowed");
  EXPECT_TRUE(workshop_.toolsStarted().empty());
  EXPECT_EQ(omissions().size(), 1u);
}

TEST_F(LeaveOut, ANewFigureBakesAnew) {
  baked();
  measure(0.5, 0.2, 0.001);
  EXPECT_THAT(workshop_.explain().at("transfer"), HasSubstr("depends"));
  EXPECT_EQ(baked(), "shadowed");
  EXPECT_THAT(workshop_.record().at("stages").at("transfer").at("reason"),
              HasSubstr("transport changed from \"interreflected\" to \"shadowed\""));
}

TEST_F(LeaveOut, SurveyIsNotRunWhereNoRuleCouldChangeAnything) {
  workshop_.writeAssetFile("cube",
                           {{"mesh", "cube.obj"}, {"stages", {{"transfer", {{"transport", "unshadowed"}}}}}});
  EXPECT_EQ(baked(), "unshadowed");
  EXPECT_THAT(workshop_.toolsStarted(), ElementsAre("transfer"));
  EXPECT_EQ(workshop_.record().at("stages").at("survey").at("status"), "left-out");
}

TEST_F(LeaveOut, AnAssetOrTheCommandLineCanKeepEverything) {
  measure(0, 0, 0);
  workshop_.options.keep_all = true;
  EXPECT_EQ(baked(), "interreflected");
  workshop_.options.keep_all = false;
  EXPECT_EQ(baked(), "unshadowed");
  workshop_.writeAssetFile("cube", {{"mesh", "cube.obj"}, {"leave_out", false}});
  EXPECT_EQ(baked(), "interreflected");
}

TEST_F(LeaveOut, ALinkedParameterFollowsWhateverTheOtherIsSetTo) {
  const auto tint = [&] {
    baked();
    return workshop_.record().at("stages").at("survey").at("ingredients").at("parameters").at("tint");
  };
  EXPECT_EQ(tint(), "white");
  workshop_.options.settings = {parseSetting("transfer.tint=red")};
  EXPECT_EQ(tint(), "red");
  workshop_.options.settings.push_back(parseSetting("survey.tint=blue"));
  EXPECT_EQ(tint(), "blue") << "what a person says counts more than the link";
}

TEST_F(LeaveOut, AFigureThatNobodyTellsIsAnErrorOfTheStage) {
  recipe_["stages"]["transfer"]["leave_out"][0]["figure"] = "survey.convexity";
  workshop_.disk.write("recipes/prt.json", recipe_.dump());
  const BuildResult result = workshop_.run();
  EXPECT_NE(result.exitStatus(), 0);
  EXPECT_THAT(workshop_.record().at("stages").at("transfer").at("error").get<std::string>(),
              HasSubstr("the stage survey tells no figure \"convexity\""));
}

TEST_F(LeaveOut, MistakesInRulesAndLinksAreToldWithTheirPlace) {
  const auto problemsWith = [&](const std::string& pointer, const Json& value) {
    Json broken = recipe_;
    broken[Json::json_pointer(pointer)] = value;
    workshop_.disk.write("recipes/prt.json", broken.dump());
    const std::vector<std::string> problems = workshop_.problems();
    return problems.empty() ? "" : problems.front();
  };
  const std::string rule = "/stages/transfer/leave_out/1";
  EXPECT_EQ(problemsWith(rule + "/at_most", 0.1), "") << "no mistake";
  EXPECT_THAT(problemsWith(rule + "/at_most", "little"), HasSubstr(rule + "/at_most"));
  EXPECT_THAT(problemsWith(rule + "/figure", "surwey.bounces"), HasSubstr("write \"survey\""));
  EXPECT_THAT(problemsWith(rule + "/set", Json::object()), HasSubstr("changes nothing"));
  EXPECT_THAT(problemsWith(rule + "/set/transport", {{"interreflected", "fast"}}), HasSubstr("one of"));
  EXPECT_THAT(problemsWith(rule + "/wenn", 1), HasSubstr("unknown key"));
  EXPECT_THAT(problemsWith("/stages/survey/parameters/tint", {{"same_as", "transfer.tnt"}}),
              HasSubstr("has no parameter"));
  EXPECT_THAT(problemsWith("/stages/survey/parameters/tint", {{"same_as", "survey.tint"}}),
              HasSubstr("circle"));
}

}  // namespace
}  // namespace bakelight::pipeline
