#include "tools/report/plan.h"

#include <gtest/gtest.h>

#include <functional>

#include "formats/error.h"

namespace bakelight::report {
namespace {

using formats::Json;

Json goodPlan() {
  return formats::parseJson(R"({
    "asset": "bunny",
    "views": [{"name": "studio front", "light": "studio", "camera": "front",
               "environment": {"path": "/p/studio.exr", "hash": "e"}, "lights": null, "windowing": -1,
               "frame": {"width": 320, "height": 240, "yaw_deg": -30, "background": "environment"},
               "reference": {"path": "/r/truth.exr", "hash": "t"}}],
    "variants": [{"name": "a", "parameters": {"transfer.order": 4, "pack.storage": "cpca"},
                  "pack": {"path": "/a.glb", "hash": "a"},
                  "stages": [{"stage": "transfer", "wall_s": 1.5, "cpu_s": 3, "peak_memory_bytes": 12, "bytes": 7, "warnings": ["w"]}],
                  "left_out": [{"stage": "transfer", "what": "bounces", "figure": "survey.x", "value": 0.1, "threshold": 0.2, "error": null}],
                  "player": {"light_change_ms": 2, "frame_ms": 5, "frame_ms_low": 4, "frame_ms_high": 7, "gpu_bytes": 9,
                             "gpu_frame_ms": 3, "gpu_frame_ms_high": 6},
                  "chain": [{"cause": "simplification", "references": [{"path": "/s.exr", "hash": "s"}]},
                            {"cause": "storage", "pack": {"path": "/a.glb", "hash": "a"}}]}],
    "failed": [{"name": "b", "stage": "transfer", "reason": "no memory"}]})",
                            "good");
}

TEST(Plan, IsReadWithAllItsParts) {
  const Plan plan = planFromJson(goodPlan(), "plan.json");
  EXPECT_EQ(plan.asset, "bunny");
  ASSERT_EQ(plan.views.size(), 1u);
  EXPECT_EQ(plan.views[0].environment_path, "/p/studio.exr");
  EXPECT_TRUE(plan.views[0].lights_path.empty());
  EXPECT_EQ(plan.views[0].windowing, -1);
  EXPECT_EQ(plan.views[0].frame.yaw_deg, -30);
  EXPECT_EQ(plan.views[0].frame.background, formats::Background::kTransparent) << "whatever the view says";
  ASSERT_EQ(plan.variants.size(), 1u);
  const PlanVariant& variant = plan.variants[0];
  EXPECT_EQ(variant.parameters["transfer.order"], 4);
  EXPECT_EQ(variant.stages[0].peak_memory_bytes, 12u);
  EXPECT_EQ(variant.stages[0].warnings, std::vector<std::string>{"w"});
  EXPECT_FALSE(variant.left_out[0].error);
  EXPECT_EQ(variant.gl->frame_ms.median, 5);
  EXPECT_EQ(variant.gl->frame_ms.high, 7);
  EXPECT_EQ(variant.gl->light_change_ms.low, 2) << "the median, where there are no quartiles";
  EXPECT_EQ(variant.gl->gpu_frame_ms->median, 3);
  EXPECT_EQ(variant.gl->gpu_frame_ms->high, 6);
  EXPECT_FALSE(variant.gl->gpu_light_change_ms) << "an older player tells none";
  EXPECT_EQ(variant.chain[0].references[0].hash, "s");
  EXPECT_EQ(variant.chain[1].pack.path, "/a.glb");
  EXPECT_EQ(plan.failed[0].reason, "no memory");
}

TEST(Plan, MayLackWhatADriverCannotGive) {
  Json json = goodPlan();
  json.erase("failed");
  for (const char* key : {"stages", "left_out", "chain"}) json["variants"][0].erase(key);
  json["variants"][0]["player"] = nullptr;
  json["views"][0]["windowing"] = "measured";
  EXPECT_TRUE(planFromJson(json, "plan.json").views[0].windows_measured);
  EXPECT_EQ(planFromJson(json, "plan.json").views[0].windowing, 0);
  json["views"][0].erase("windowing");
  const Plan plan = planFromJson(json, "plan.json");
  EXPECT_FALSE(plan.variants[0].gl);
  EXPECT_TRUE(plan.variants[0].chain.empty());
}

// What is wrong, and where the error says that it is.
TEST(Plan, MistakesAreNamedWhereTheyStand) {
  const struct {
    std::function<void(Json&)> break_it;
    std::string pointer;
  } cases[] = {{[](Json& j) { j.erase("asset"); }, ""},
               {[](Json& j) { j["varients"] = 1; }, "/varients"},
               {[](Json& j) { j["views"] = Json::array(); }, "/views"},
               {[](Json& j) { j["views"][0]["frame"]["widht"] = 3; }, "/views/0/frame/widht"},
               {[](Json& j) { j["views"][0]["reference"] = "truth.exr"; }, "/views/0/reference"},
               {[](Json& j) { j["views"][0]["windowing"] = "much"; }, "/views/0/windowing"},
               {[](Json& j) {
                  j["views"].push_back(j["views"][0]);
                  j["views"][1]["name"] = "other";
                  j["views"][1]["windowing"] = "measured";
                },
                "/views"},
               {[](Json& j) { j["variants"] = Json::object(); }, "/variants"},
               {[](Json& j) { j["variants"][0]["pack"].erase("hash"); }, "/variants/0/pack"},
               {[](Json& j) { j["variants"][0]["parameters"] = 4; }, "/variants/0/parameters"},
               {[](Json& j) { j["variants"][0]["stages"][0]["wall_s"] = -1; }, "/variants/0/stages/0/wall_s"},
               {[](Json& j) { j["variants"][0]["player"].erase("frame_ms"); }, "/variants/0/player"},
               {[](Json& j) { j["variants"][0]["chain"][1].erase("pack"); }, "/variants/0/chain/1"},
               {[](Json& j) { j["variants"][0]["chain"][0]["references"] = Json::array(); },
                "/variants/0/chain/0/references"},
               {[](Json& j) { j["variants"].push_back(j["variants"][0]); }, "/variants"},
               {[](Json& j) { j["failed"][0]["reason"] = 5; }, "/failed/0/reason"}};
  for (const auto& [break_it, pointer] : cases) {
    Json json = goodPlan();
    break_it(json);
    try {
      planFromJson(json, "plan.json");
      ADD_FAILURE() << pointer;
    } catch (const Error& error) {
      EXPECT_EQ(error.place().pointer, pointer);
      EXPECT_EQ(error.place().file, "plan.json");
      EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    }
  }
}

}  // namespace
}  // namespace bakelight::report
