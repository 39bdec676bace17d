#include "pipeline/recipe.h"

#include "formats/error.h"
#include "formats/json.h"
#include "pipeline/problems.h"
#include "workshop.h"

namespace bakelight::pipeline {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using Json = nlohmann::json;

std::string problemsOf(const Json& json) {
  try {
    parseRecipe(json, "test", "test.json");
  } catch (const ProblemsFound& found) {
    return found.what();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

Json stage(const Json& inputs, const std::string& output) {
  return {{"tool", "any"}, {"inputs", inputs}, {"outputs", {{"o", output}}}};
}

TEST(Recipe, StagesInOrderPutMakersFirst) {
  const Recipe recipe = parseRecipe({{"stages",
                                      {{"a", stage({{"i", "c.o"}}, "a")},
                                       {"b", stage(Json::object(), "b")},
                                       {"c", stage({{"i", "b.o"}}, "c")}}}},
                                    "test", "test.json");
  EXPECT_THAT(stagesInOrder(recipe), ElementsAre("b", "c", "a"));
}

TEST(Recipe, CycleNamesItsStages) {
  EXPECT_THAT(problemsOf({{"stages",
                           {{"a", stage({{"i", "b.o"}}, "a")},
                            {"b", stage({{"i", "a.o"}}, "b")},
                            {"free", stage(Json::object(), "f")}}}}),
              HasSubstr("test.json, at /stages: the stages a, b wait for each other"));
}

class ExtendedRecipe : public testing::Test {
 protected:
  ExtendedRecipe() {
    write("base", {{"summary", "all of it"},
                   {"asset", {{"mesh", {{"kind", "mesh"}, {"endings", {".obj"}}}}}},
                   {"stages",
                    {{"a",
                      {{"inputs", {{"i", "asset.mesh"}}},
                       {"outputs", {{"o", "a"}}},
                       {"parameters", {{"p", 1}, {"q", 2}}}}},
                     {"b", {{"inputs", {{"i", "a.o"}}}, {"outputs", {{"o", "b"}}}}}}},
                   {"deliver", {{"a", "a.o"}, {"b", "b.o"}}},
                   {"report", {{"vary", {"a.p=1..2"}}, {"pack", "a.o"}}}});
  }
  void write(const std::string& name, const Json& json) {
    disk_.write("recipes/" + name + ".json", json.dump());
  }
  const Recipe& read(const std::string& name) { return book_.require(name, {"asset.json", "", "/recipe"}); }
  std::string problemOf(const std::string& name) {
    try {
      read(name);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }

  FakeDisk disk_;
  RecipeBook book_{"recipes", disk_};
};

TEST_F(ExtendedRecipe, SaysOnlyWhatItAddsChangesAndTakesAway) {
  write("more", {{"extends", "base"},
                 {"stages",
                  {{"a", {{"parameters", {{"q", 3}, {"r", {{"same_as", "a.p"}}}}}}},
                   {"b", nullptr},
                   {"c", {{"inputs", {{"i", "a.o"}}}, {"outputs", {{"o", "c"}}}}}}},
                 {"deliver", {{"b", nullptr}, {"c", "c.o"}}},
                 {"report", {{"vary+", {"a.q=1,2"}}}}});
  const Recipe& more = read("more");
  EXPECT_EQ(more.name, "more");
  EXPECT_EQ(more.summary, "all of it");
  EXPECT_THAT(more.stageNames(), ElementsAre("a", "c"));
  EXPECT_THAT(more.deliverableNames(), ElementsAre("a", "c"));
  EXPECT_EQ(more.stages.at("a").parameters, Json({{"p", 1}, {"q", 3}}));
  EXPECT_EQ(more.stages.at("a").linked.at("r").text(), "a.p");
  EXPECT_EQ(more.report, Json({{"vary", {"a.p=1..2", "a.q=1,2"}}, {"pack", "a.o"}}));
  write("most", {{"extends", "more"}, {"summary", "more still"}});
  EXPECT_EQ(read("most").summary, "more still");
  EXPECT_THAT(read("most").stageNames(), ElementsAre("a", "c"));
  EXPECT_THAT(read("base").stageNames(), ElementsAre("a", "b"));
}

TEST_F(ExtendedRecipe, NamesWhatIsWrong) {
  write("lost", {{"extends", "bass"}});
  EXPECT_THAT(problemOf("lost"), AllOf(HasSubstr("lost.json, at /extends"), HasSubstr("base")));
  write("one", {{"extends", "two"}});
  write("two", {{"extends", "one"}});
  EXPECT_THAT(problemOf("one"), AllOf(HasSubstr("two.json, at /extends"), HasSubstr("one, two, one")));
  write("appending", {{"extends", "base"}, {"report", {{"pack+", {"b.o"}}}}});
  EXPECT_THAT(problemOf("appending"), HasSubstr("appending.json, at /report/pack+"));
  write("number", {{"extends", 3}});
  EXPECT_THAT(problemOf("number"), HasSubstr("/extends"));
}

TEST(Recipe, WireToNothingSuggestsTheNearest) {
  EXPECT_THAT(
      problemsOf(
          {{"stages", {{"simplify", stage(Json::object(), "m")}, {"b", stage({{"i", "simplfy.o"}}, "b")}}}}),
      AllOf(HasSubstr("/stages/b/inputs/i"), HasSubstr("write \"simplify.o\"")));
  EXPECT_THAT(problemsOf({{"stages", {{"b", stage({{"i", "nodot"}}, "b")}}}}), HasSubstr("no wire"));
  EXPECT_THAT(
      problemsOf({{"stages", {{"b", stage(Json::object(), "b")}}}, {"deliver", {{"d", "asset.mesh"}}}}),
      HasSubstr("/deliver/d"));
}

TEST(Recipe, UnknownKeysAndWrongTypesAtEachLevel) {
  EXPECT_THAT(problemsOf({{"stage", 1}}), AllOf(HasSubstr("at /stage:"), HasSubstr("\"stages\"")));
  EXPECT_THAT(problemsOf({{"stages", {{"a", {{"input", 1}}}}}}), HasSubstr("at /stages/a/input:"));
  EXPECT_THAT(problemsOf({{"asset", {{"mesh", {{"kind", "mesh"}, {"ending", ".obj"}}}}}}),
              HasSubstr("at /asset/mesh/ending:"));
  EXPECT_THAT(problemsOf({{"stages", 3}}), HasSubstr("at /stages: it is a number"));
  EXPECT_THAT(problemsOf({{"stages", {{"asset", stage(Json::object(), "a")}}}}),
              HasSubstr("at /stages/asset"));
}

TEST(Recipe, OutputIsAFileNameWithoutFolder) {
  EXPECT_THAT(problemsOf({{"stages", {{"a", stage(Json::object(), "../a")}}}}),
              HasSubstr("/stages/a/outputs/o"));
}

TEST(Recipe, ExpandsTheAssetNameOnly) {
  EXPECT_EQ(expand("{asset}-{asset}.glb", "cube", {}), "cube-cube.glb");
  EXPECT_EQ(expand("plain", "cube", {}), "plain");
  EXPECT_THROW(expand("{stage}.glb", "cube", {}), Error);
}

// The graph checks a recipe against what the tools say; the recipe here is prt with one thing changed.
std::vector<std::string> problemsWith(const std::string& pointer, const Json& value) {
  Workshop workshop;
  Json recipe = formats::parseJson(workshop.disk.read("recipes/prt.json"), "prt.json");
  recipe[Json::json_pointer(pointer)] = value;
  workshop.disk.write("recipes/prt.json", recipe.dump());
  return workshop.problems();
}

TEST(Graph, RecipeIsCheckedAgainstTheTools) {
  EXPECT_THAT(problemsWith("/stages/transfer/inputs/mesch", "simplify.simplified"),
              ElementsAre(AllOf(HasSubstr("/stages/transfer/inputs/mesch"), HasSubstr("write \"mesh\""))));
  EXPECT_THAT(problemsWith("/stages/transfer/inputs", Json::object()),
              ElementsAre(AllOf(HasSubstr("/stages/transfer/inputs/mesh"), HasSubstr("not wired"))));
  EXPECT_THAT(problemsWith("/stages/transfer/outputs/other", "o.bin"),
              ElementsAre(HasSubstr("has no output \"other\"")));
  EXPECT_THAT(problemsWith("/stages/pack/inputs/transfer", "simplify.simplified"),
              ElementsAre(HasSubstr("kind \"mesh\" is wired")));
  EXPECT_THAT(problemsWith("/stages/transfer/parameters", {{"order", 11}}),
              ElementsAre(HasSubstr("recipes/prt.json, at /stages/transfer/parameters/order")));
  EXPECT_THAT(problemsWith("/stages/transfer/tool", "transfr"),
              ElementsAre(HasSubstr("no tool \"transfr\"")));
}

TEST(Graph, InputsOfAnyKindTakeAll) {
  const Json look = {{"inputs", {{"file", "simplify.simplified"}}}, {"outputs", {{"picture", "look.png"}}}};
  for (const std::string kind : {"any", "image"}) {
    Workshop workshop;
    const Json description = {
        {"tool", "look"},
        {"summary", ""},
        {"execution_path", ""},
        {"inputs", {{{"name", "file"}, {"kind", kind}, {"required", true}, {"help", ""}}}},
        {"outputs", {{{"name", "picture"}, {"kind", "image"}, {"required", true}, {"help", ""}}}},
        {"parameters", Json::array()}};
    workshop.runner.install("look", {description, {}});
    Json recipe = formats::parseJson(workshop.disk.read("recipes/prt.json"), "recipes/prt.json");
    recipe["stages"]["look"] = look;
    recipe["deliver"]["look"] = "look.picture";
    workshop.disk.write("recipes/prt.json", recipe.dump());
    if (kind == "any")
      EXPECT_THAT(workshop.problems(), testing::IsEmpty());
    else
      EXPECT_THAT(workshop.problems(), ElementsAre(HasSubstr("kind \"mesh\" is wired")));
  }
}

TEST(Graph, OutputsMustNotMeet) {
  EXPECT_THAT(problemsWith("/stages/frame/outputs/image", "{asset}.glb"),
              ElementsAre(HasSubstr("would overwrite")));
  EXPECT_THAT(problemsWith("/stages/frame/outputs/image", "record.json"),
              ElementsAre(HasSubstr("would overwrite")));
  EXPECT_THAT(problemsWith("/stages/transfer/outputs/transfer", "stats.json"),
              ElementsAre(HasSubstr("would overwrite")));
}

TEST(Graph, ToolThatIsNotBuiltMattersOnlyIfItsStageIsNeeded) {
  Workshop workshop;
  workshop.disk.removeAll("tools/player");
  EXPECT_THAT(workshop.problems(), ElementsAre(HasSubstr("no tool \"player\"")));
  workshop.options.deliver = {"pack"};
  EXPECT_THAT(workshop.problems(), testing::IsEmpty());
}

TEST(Graph, SettingsAreCheckedAndNamed) {
  Workshop workshop;
  workshop.options.settings = {parseSetting("transfer.order=99"), parseSetting("transfer.ordr=1"),
                               parseSetting("trnsfer.order=1")};
  EXPECT_THAT(
      workshop.problems(),
      testing::UnorderedElementsAre(HasSubstr("--set transfer.order=99"), HasSubstr("--set transfer.ordr=1"),
                                    AllOf(HasSubstr("--set trnsfer.order=1"), HasSubstr("\"transfer\""))));
  EXPECT_THROW(parseSetting("order=5"), Error);
  EXPECT_THROW(parseSetting("transfer.order"), Error);
  EXPECT_EQ(parseSetting("pack.name=a.b=c").value, "a.b=c");
}

TEST(Graph, AParameterOfAnotherStageIsSuggested) {
  Workshop workshop;
  workshop.options.settings = {parseSetting("pack.order=4")};
  EXPECT_THAT(workshop.problems(), testing::ElementsAre(testing::HasSubstr("write transfer.order")));
}

TEST(Graph, SettingsWinOverAssetAndAssetOverRecipe) {
  Workshop workshop;
  workshop.writeAssetFile("cube", {{"mesh", "cube.obj"},
                                   {"stages", {{"pack", {{"name", "mine"}}}, {"transfer", {{"order", 2}}}}}});
  workshop.options.settings = {parseSetting("transfer.order=7")};
  const Graph graph = workshop.graph();
  EXPECT_EQ(graph.tasks[1].parameters["order"], 7);
  EXPECT_EQ(graph.tasks[2].parameters["name"], "mine");
}

TEST(Graph, TextParametersTakeTheirValueAsTyped) {
  Workshop workshop;
  workshop.options.settings = {parseSetting("pack.name=42")};
  EXPECT_EQ(workshop.graph().tasks[2].parameters["name"], "42");
}

TEST(Graph, DeliverIsChecked) {
  Workshop workshop;
  workshop.options.deliver = {"frme"};
  EXPECT_THAT(workshop.problems(), ElementsAre(AllOf(HasSubstr("--deliver frme"), HasSubstr("\"frame\""))));
}

}  // namespace
}  // namespace bakelight::pipeline
