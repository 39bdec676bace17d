#include "pipeline/explain.h"

#include "workshop.h"

namespace bakelight::pipeline {
namespace {

TEST(Explain, NeverRun) {
  Workshop workshop;
  auto told = workshop.explain();
  EXPECT_EQ(told["simplify"], "would run: never run");
  EXPECT_EQ(told["transfer"], "depends: on what simplify will make");
  EXPECT_EQ(told["pack"], "depends: on what simplify and transfer will make");
  EXPECT_TRUE(workshop.disk.pathsContaining("out/").empty()) << "explaining leaves no trace";
}

TEST(Explain, UpToDate) {
  Workshop workshop;
  workshop.run();
  const auto told = workshop.explain();
  ASSERT_EQ(told.size(), 4u);
  for (const auto& [stage, text] : told) EXPECT_EQ(text, "up to date") << stage;
}

TEST(Explain, ChangedParameterAlsoWhereInputsAreNotMadeYet) {
  Workshop workshop;
  workshop.run();
  workshop.options.settings = {parseSetting("simplify.triangles=50"), parseSetting("transfer.order=4")};
  auto told = workshop.explain();
  EXPECT_EQ(told["simplify"], "would run: triangles changed from 100 to 50");
  EXPECT_EQ(told["transfer"], "depends: on what simplify will make; order changed from 5 to 4");
}

TEST(Explain, ChangedInputNamesWhereItCameFrom) {
  Workshop workshop;
  workshop.run();
  workshop.disk.write("assets/cube/sky.hdr", "red");
  EXPECT_EQ(workshop.explain()["frame"], "would run: input environment changed (assets/cube/sky.hdr)");
}

TEST(Explain, LostInputIsNoted) {
  Workshop workshop;
  workshop.run();
  workshop.disk.removeAll("assets/cube/sky.hdr");
  EXPECT_EQ(workshop.explain()["frame"], "would run: input environment is no longer given");
}

TEST(Explain, RebuiltTool) {
  Workshop workshop;
  workshop.run();
  workshop.disk.write("tools/transfer", "2");
  EXPECT_EQ(workshop.explain()["transfer"], "would run: tool transfer was rebuilt");
}

TEST(Explain, EmptiedCache) {
  Workshop workshop;
  workshop.run();
  workshop.disk.removeAll("out/.cache");
  EXPECT_EQ(workshop.explain()["simplify"], "would run: the cache has it no more");
}

TEST(Explain, AnotherAssetMadeTheSame) {
  Workshop workshop;
  workshop.run();
  workshop.addAsset("twin", "eight corners");
  EXPECT_EQ(workshop.explain({"assets/twin"})["simplify"], "would come from the cache: never run");
}

TEST(Explain, InterruptedLastTime) {
  Workshop workshop;
  workshop.runner.interrupt_after = 2;
  workshop.run();
  EXPECT_EQ(workshop.explain()["transfer"], "would run: interrupted last time");
}

TEST(Ingredients, DifferencesInPlainWords) {
  const Ingredients before{.tool = "transfer",
                           .tool_hash = "1",
                           .execution_path = "sse",
                           .parameters = {{"order", 5}, {"old", true}},
                           .inputs = {{"mesh", {"a", ".ply"}}}};
  Ingredients now = before;
  EXPECT_THAT(differences(before, now, {{"mesh", "m.ply"}}), testing::IsEmpty());
  now.execution_path = "avx";
  now.parameters = {{"order", 4}, {"new", 0.5}};
  now.inputs["mesh"].hash = "b";
  EXPECT_THAT(differences(before, now, {{"mesh", "simplify made a different mesh.ply"}}),
              testing::ElementsAre("the execution path changed from \"sse\" to \"avx\"",
                                   "new is new, with the value 0.5", "order changed from 5 to 4",
                                   "old is no longer a parameter",
                                   "input mesh changed (simplify made a different mesh.ply)"));
}

TEST(Ingredients, EveryPartIsInTheKey) {
  const Ingredients base{.tool = "t",
                         .tool_hash = "1",
                         .execution_path = "",
                         .parameters = {{"order", 5}},
                         .inputs = {{"mesh", {"a", ".ply"}}},
                         .outputs = {{"o", "o.bin"}}};
  std::set<std::string> keys = {base.key()};
  const auto expect_new = [&](auto change) {
    Ingredients other = base;
    change(other);
    EXPECT_TRUE(keys.insert(other.key()).second);
  };
  expect_new([](Ingredients& i) { i.tool = "u"; });
  expect_new([](Ingredients& i) { i.tool_hash = "2"; });
  expect_new([](Ingredients& i) { i.execution_path = "avx"; });
  expect_new([](Ingredients& i) { i.parameters["order"] = 6; });
  expect_new([](Ingredients& i) { i.inputs["mesh"].hash = "b"; });
  expect_new([](Ingredients& i) { i.inputs["mesh"].ending = ".obj"; });
  expect_new([](Ingredients& i) { i.outputs["o"] = "p.bin"; });
  EXPECT_EQ(ingredientsFromJson(toJson(base))->key(), base.key());
}

}  // namespace
}  // namespace bakelight::pipeline
