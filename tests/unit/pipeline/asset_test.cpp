#include "pipeline/asset.h"

#include "workshop.h"

namespace bakelight::pipeline {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::string> namesOf(const Graph& graph) {
  std::vector<std::string> names;
  for (const Asset& asset : graph.assets) names.push_back(asset.name);
  return names;
}

TEST(Asset, FolderWithOneMeshTakesItsOneProbe) {
  Workshop workshop;
  const Graph graph = workshop.graph({"assets/cube/"});
  ASSERT_THAT(namesOf(graph), ElementsAre("cube"));
  EXPECT_EQ(graph.assets[0].files.at("mesh"), "assets/cube/cube.obj");
  EXPECT_EQ(graph.assets[0].files.at("environment"), "assets/cube/sky.hdr");
}

TEST(Asset, TwoProbesAreAmbiguousSoNoneIsTaken) {
  Workshop workshop;
  workshop.disk.write("assets/cube/night.exr", "black");
  EXPECT_EQ(workshop.graph().assets[0].files.count("environment"), 0u);
}

TEST(Asset, MeshFileIsAnAssetOfItsName) {
  Workshop workshop;
  workshop.disk.write("models/Horse.3DS", "horse");
  EXPECT_THAT(namesOf(workshop.graph({"models/Horse.3DS"})), ElementsAre("Horse"));
}

TEST(Asset, FolderOfSeveralTakesMeshesAndSubFoldersOneLevelDeep) {
  Workshop workshop;
  workshop.disk.write("many/a.obj", "a");
  workshop.disk.write("many/b.ply", "b");
  workshop.disk.write("many/notes.txt", "no asset");
  workshop.disk.write("many/c/mesh.stl", "c");
  workshop.disk.write("many/textures/wood.png", "no asset");
  workshop.disk.write("many/.hidden/mesh.obj", "no asset");
  workshop.disk.write("many/deep/deeper/mesh.obj", "no asset");
  workshop.disk.write("many/d/asset.json", R"({"mesh": "../a.obj", "name": "d4"})");
  EXPECT_THAT(namesOf(workshop.graph({"many"})), ElementsAre("a", "b", "c", "d4"));
}

TEST(Asset, AssetFileSettlesAll) {
  Workshop workshop;
  workshop.disk.write("data/models/bunny.obj", "bunny");
  workshop.writeAssetFile("bunny", {{"mesh", "data:models/bunny.obj"},
                                    {"environment", "../cube/sky.hdr"},
                                    {"deliver", {"pack"}},
                                    {"stages", {{"transfer", {{"order", 3}}}}}});
  const Graph graph = workshop.graph({"assets/bunny"});
  ASSERT_THAT(namesOf(graph), ElementsAre("bunny"));
  EXPECT_EQ(graph.assets[0].files.at("mesh"), "data/models/bunny.obj");
  EXPECT_EQ(graph.assets[0].files.at("environment"), "assets/cube/sky.hdr");
  EXPECT_EQ(graph.tasks[1].parameters["order"], 3);
  EXPECT_EQ(graph.tasks[3].left_out, kNotNeeded);
}

TEST(Asset, EmptyFolderSaysWhatWasExpected) {
  Workshop workshop;
  workshop.disk.makeFolders("empty");
  EXPECT_THAT(workshop.problems({"empty"}),
              ElementsAre(AllOf(HasSubstr("empty: has no asset"), HasSubstr("asset.json"))));
}

TEST(Asset, MissingPathAndOtherFiles) {
  Workshop workshop;
  workshop.disk.write("readme.txt", "words");
  EXPECT_THAT(workshop.problems({"nowhere", "readme.txt"}),
              ElementsAre(HasSubstr("nowhere: does not exist"), HasSubstr("readme.txt: is not a mesh file")));
}

TEST(Asset, TwoOfOneName) {
  Workshop workshop;
  workshop.disk.write("other/cube.obj", "another");
  EXPECT_THAT(
      workshop.problems({"assets/cube", "other/cube.obj"}),
      ElementsAre(AllOf(HasSubstr("second asset of the name \"cube\""), HasSubstr("assets/cube/cube.obj"))));
}

TEST(Asset, MeshesOfOneFolderThatDifferInTheirEndingOnlyKeepIt) {
  Workshop workshop;
  workshop.disk.write("models/cat.obj", "a cat");
  workshop.disk.write("models/cat.ply", "another");
  workshop.disk.write("models/dog.ply", "a dog");
  EXPECT_THAT(namesOf(workshop.graph({"models"})), ElementsAre("cat.obj", "cat.ply", "dog"));
}

TEST(Asset, NameMustBeAFolderName) {
  for (const std::string name : {"", "a/b", ".cache"}) {
    Workshop workshop;
    workshop.writeAssetFile("cube", {{"mesh", "cube.obj"}, {"name", name}});
    EXPECT_THAT(workshop.problems(), ElementsAre(HasSubstr("cannot be the name of an asset"))) << name;
  }
}

TEST(Asset, UnknownKeysArePointedToWithTheNearestName) {
  Workshop workshop;
  workshop.writeAssetFile("cube", {{"mesh", "cube.obj"}, {"enviroment", "sky.hdr"}});
  EXPECT_THAT(workshop.problems(), ElementsAre(AllOf(HasSubstr("assets/cube/asset.json, at /enviroment"),
                                                     HasSubstr("\"environment\""))));
}

TEST(Asset, UnknownKeysOfTheReportArePointedTo) {
  Workshop workshop;
  workshop.writeAssetFile("cube", {{"mesh", "cube.obj"}, {"report", {{"varry", nlohmann::json::array()}}}});
  EXPECT_THAT(workshop.problems(), testing::ElementsAre(testing::HasSubstr("/report/varry")));
}

TEST(Asset, MayAskForItsReportWithEachRun) {
  for (const bool asked : {false, true}) {
    Workshop workshop;
    nlohmann::json report = {{"vary", {"pack.name=a,b"}}};
    if (asked) report["with_run"] = true;
    workshop.writeAssetFile("cube", {{"mesh", "cube.obj"}, {"report", report}});
    EXPECT_EQ(workshop.graph().assets.at(0).report_with_run, asked);
  }
  Workshop workshop;
  workshop.writeAssetFile("cube", {{"mesh", "cube.obj"}, {"report", {{"with_run", "yes"}}}});
  EXPECT_THAT(workshop.problems(), ElementsAre(HasSubstr("/report/with_run")));
}

TEST(Asset, AllMistakesAreReportedAtOnce) {
  Workshop workshop;
  workshop.writeAssetFile("cube", {{"mesh", "gone.obj"},
                                   {"environment", 7},
                                   {"deliver", {"pak"}},
                                   {"stages",
                                    {{"transfer", {{"ordre", 5}, {"order", 99}}},
                                     {"simplfy", nlohmann::json::object()},
                                     {"simplify", {{"triangles", "many"}}}}}});
  EXPECT_THAT(workshop.problems(),
              testing::UnorderedElementsAre(
                  AllOf(HasSubstr("at /mesh"), HasSubstr("gone.obj")), HasSubstr("at /environment"),
                  AllOf(HasSubstr("at /deliver/0"), HasSubstr("\"pack\"")),
                  AllOf(HasSubstr("at /stages/transfer/ordre"), HasSubstr("\"order\"")),
                  HasSubstr("at /stages/transfer/order:"),
                  AllOf(HasSubstr("at /stages/simplfy"), HasSubstr("\"simplify\"")),
                  HasSubstr("at /stages/simplify/triangles")));
  EXPECT_THAT(workshop.toolsStarted(), IsEmpty());
}

TEST(Asset, MissingProbeOfTheDataFolderSaysHowToGetIt) {
  Workshop workshop;
  workshop.writeAssetFile("cube", {{"mesh", "cube.obj"}, {"environment", "data:probes/forest.exr"}});
  EXPECT_THAT(workshop.problems(),
              ElementsAre(AllOf(HasSubstr("at /environment"), HasSubstr("data/probes/forest.exr"),
                                HasSubstr("make assets"))));
}

TEST(Asset, WrongPathIsOneMistake) {
  Workshop workshop;
  workshop.disk.write("assets/cube/asset.json", R"({"mesh": "cueb.obj"})");
  try {
    workshop.graph();
    FAIL() << "no error";
  } catch (const ProblemsFound& found) {
    ASSERT_EQ(found.errors().size(), 1U) << found.errors().back().paragraph();
    EXPECT_THAT(found.errors().front().paragraph(), HasSubstr("cueb.obj"));
  }
}

TEST(Asset, MeshIsRequired) {
  Workshop workshop;
  workshop.writeAssetFile("cube", nlohmann::json::object());
  EXPECT_THAT(workshop.problems(), testing::Contains(HasSubstr("\"mesh\" is missing")));
}

TEST(Asset, UnknownRecipe) {
  Workshop workshop;
  workshop.writeAssetFile("cube", {{"mesh", "cube.obj"}, {"recipe", "prr"}});
  EXPECT_THAT(workshop.problems(), ElementsAre(AllOf(HasSubstr("at /recipe"), HasSubstr("\"prt\""))));
}

TEST(Asset, BrokenJsonNamesTheLine) {
  Workshop workshop;
  workshop.disk.write("assets/cube/asset.json", "{\n  \"mesh\": \n}");
  EXPECT_THAT(workshop.problems(), ElementsAre(HasSubstr("asset.json, line 3")));
}

}  // namespace
}  // namespace bakelight::pipeline
