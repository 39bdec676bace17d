#include "tools/report/evaluation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "formats/error.h"
#include "tests/e2e/made_packs.h"
#include "tests/support/made_pixel_pack.h"
#include "tests/unit/report/made_report.h"
#include "tools/report/report_json.h"

namespace bakelight::report {
namespace {

using formats::Json;
using tests::madeGlossyPack, tests::MadeReport;

constexpr int kTruthOrder = 7, kRounds = 3;

const formats::Pack& truth() {
  static const formats::Pack pack = madeGlossyPack(kTruthOrder);
  return pack;
}

Evaluation evaluate(const MadeReport& made) {
  const Plan plan = made.plan();
  const Sources sources = made.sources();
  return Evaluator(plan, sources).evaluate(kRounds, [] {});
}

// The truth itself and lower orders, in a noisy reference.
TEST(Evaluation, OrderesTheErrorsAndTakesTheNoiseAway) {
  MadeReport made(truth());
  for (const int order : {2, 4, kTruthOrder})
    made.addVariant("order=" + std::to_string(order), Json::object(), madeGlossyPack(order));
  const Evaluation evaluation = evaluate(made);
  ASSERT_EQ(evaluation.variants.size(), 3u);
  const auto& variants = evaluation.variants;
  EXPECT_GT(variants[0].errors.rel_rmse, 2 * variants[1].errors.rel_rmse);
  EXPECT_GT(variants[1].errors.rel_rmse, 10 * variants[2].errors.rel_rmse);
  ASSERT_EQ(evaluation.noise.size(), 2u);
  for (std::size_t view = 0; view < 2; ++view) {
    EXPECT_GT(evaluation.noise[view], 0.005);
    // What is left is the variance of the variance: √(√2 / √(3 · pixels)) of the noise.
    EXPECT_LT(variants[2].view_errors[view].rel_rmse, 0.25 * evaluation.noise[view]);
    EXPECT_LT(variants[2].view_errors[view].coverage_error, 1e-6);
    EXPECT_GT(variants[0].view_errors[view].p99, variants[0].view_errors[view].rel_rmse);
  }
  EXPECT_GT(variants[0].errors.flip, variants[1].errors.flip);
  EXPECT_LT(variants[2].errors.flip, 0.05) << "the noise";
  for (const VariantFigures& variant : variants) {
    EXPECT_GT(variant.light_change_ms.median, 0);
    EXPECT_LE(variant.light_change_ms.low, variant.light_change_ms.median);
    EXPECT_LE(variant.light_change_ms.median, variant.light_change_ms.high);
    EXPECT_GT(variant.bytes, 1000u);
  }
}

// Each mistake of a stage shows far above the error of the good pack.
TEST(Evaluation, BrokenPacksStandOut) {
  tests::MadeFrame frame;
  frame.object_yaw_deg = 40;
  MadeReport made(truth(), frame);
  const formats::Pack good = madeGlossyPack(6);
  formats::Pack without_inverse_pi = good, flipped = good, turned = good;
  std::vector<float> vectors = good.sh().vectors.decode();
  for (float& value : vectors) value *= static_cast<float>(std::numbers::pi);
  without_inverse_pi.sh().vectors =
      formats::encodeTable(vectors, good.sh().vectors.columns, formats::Precision::kFloat32, "test", "table");
  for (auto& position : flipped.mesh.positions) position[2] = 10 - position[2];
  for (auto& tangent : turned.sh().glossy->tangents) {
    tangent[0] = -tangent[0], tangent[1] = -tangent[1], tangent[2] = -tangent[2];
  }
  made.addVariant("good", Json::object(), good);
  made.addVariant("without 1/pi", Json::object(), without_inverse_pi);
  made.addVariant("z flipped", Json::object(), flipped);
  made.addVariant("frames turned", Json::object(), turned);
  const Evaluation evaluation = evaluate(made);
  const double error = evaluation.variants[0].errors.rel_rmse;
  EXPECT_LT(error, 0.05);
  for (std::size_t v = 1; v < evaluation.variants.size(); ++v)
    EXPECT_GT(evaluation.variants[v].errors.rel_rmse, 4 * error) << made.json["variants"][v]["name"];
}

// Links in a row: each cause is the distance of neighbours, in units of the truth.
TEST(Evaluation, SplitsTheErrorIntoItsCauses) {
  MadeReport made(truth());
  formats::Pack rounded = madeGlossyPack(3);
  tests::encodeAt(formats::Precision::kUint8, rounded);
  const Json chain = {{{"cause", "simplification"}, {"references", made.addReferences("same", truth())}},
                      {{"cause", "sh_truncation"}, {"pack", made.addPack("plain", madeGlossyPack(3))}},
                      {{"cause", "storage"}, {"pack", made.addPack("rounded", rounded)}}};
  made.addVariant("rounded", Json::object(), rounded, chain);
  made.addVariant("plain", Json::object(), madeGlossyPack(3));
  const Evaluation evaluation = evaluate(made);
  const auto& causes = evaluation.variants[0].causes;
  ASSERT_EQ(causes.size(), 3u);
  EXPECT_EQ(causes[0].cause, "simplification");
  EXPECT_LT(causes[0].rel_rmse, 0.004) << "only noise";
  EXPECT_NEAR(causes[1].rel_rmse, evaluation.variants[1].errors.rel_rmse, 0.002);
  EXPECT_GT(causes[2].rel_rmse, 0.0005);
  EXPECT_LT(causes[2].rel_rmse, 0.2 * causes[1].rel_rmse);
  EXPECT_FALSE(evaluation.variants[0].leftOutError());
}

TEST(Evaluation, LeftOutHasItsMeasuredError) {
  MadeReport made(truth());
  const Json chain = {{{"cause", "sh_truncation"}, {"pack", made.addPack("four", madeGlossyPack(4))}},
                      {{"cause", "left_out"}, {"pack", made.addPack("three", madeGlossyPack(3))}}};
  Json& variant = made.addVariant("three", Json::object(), madeGlossyPack(3), chain);
  variant["left_out"] = {{{"stage", "transfer"},
                          {"what", "bounces"},
                          {"figure", "survey.bounce_energy"},
                          {"value", 0.001},
                          {"threshold", 0.005},
                          {"error", 0.001}}};
  made.addVariant("again", Json::object(), madeGlossyPack(3), chain)["left_out"] =
      made.json["variants"][0]["left_out"];
  const Plan plan = made.plan();
  const Json report = reportJson(plan, evaluate(made));
  const Json& left_out = report["variants"][0]["left_out"][0];
  EXPECT_EQ(left_out["figure"], "survey.bounce_energy");
  EXPECT_GT(left_out["measured_error"].get<double>(), 0.01);
  EXPECT_EQ(left_out["measured_error"], report["variants"][0]["causes"][1]["rel_rmse"]);
  ASSERT_EQ(report["left_out"].size(), 1u) << "the same omission of two variants";
  EXPECT_EQ(report["left_out"][0]["variants"], Json({"three", "again"}));
}

// Of the first exact matrix in a pixel basis: exact ways have no error, the others some, and all are in the JSON.
TEST(Evaluation, ComparesWaysToStoreAMatrix) {
  const formats::Pack sphere = tests::spherePack(3, 12);
  formats::Pack pack = tests::madePixelPack(sphere.mesh);
  pack.transfer = tests::madePixelTransfer(pack.mesh, 8);
  MadeReport made(sphere);
  made.addVariant("pixels", Json::object(), pack);
  const Plan plan = made.plan();
  const Evaluation evaluation = evaluate(made);
  ASSERT_TRUE(evaluation.storage);
  const StorageFigures& storage = *evaluation.storage;
  EXPECT_EQ(storage.rows, 16 * pack.mesh.vertexCount());
  std::map<std::string, int> names;
  for (const StorageMethod& method : storage.methods) {
    ++names[method.name];
    ASSERT_EQ(method.incident_errors.size(), 2u);
    ASSERT_EQ(method.picture_errors.size(), 2u);
    EXPECT_GT(method.bytes, 0u);
    EXPECT_GT(method.operations, 0u);
    const bool exact = method.name == "rows" || method.name == "sums";
    for (std::size_t view = 0; view < 2; ++view) {
      if (exact) {
        EXPECT_LT(method.incident_errors[view], 1e-5) << method.name;
        const double own = evaluation.variants[0].view_errors[view].rel_rmse;
        EXPECT_NEAR(method.picture_errors[view], own, 1e-4 * own) << method.name;
      } else {
        EXPECT_GT(method.incident_errors[view], 1e-4) << method.name;
      }
    }
  }
  EXPECT_EQ(names["rows"], 1);
  EXPECT_EQ(names["sums"], 1);
  EXPECT_GE(names["haar"], 1);
  EXPECT_GE(names["wavelets4d"], 1);
  EXPECT_GE(names["sums_within"] + names["cpca"], 1);
  const Json json = reportJson(plan, evaluation);
  ASSERT_EQ(json["storage"]["methods"].size(), storage.methods.size());
  EXPECT_EQ(json["storage"]["methods"][0]["name"], "rows");
  EXPECT_TRUE(json["storage"]["methods"][0]["picture_errors"].contains(plan.views[0].name));
  const Sources sources = made.sources();
  EXPECT_FALSE(Evaluator(plan, sources)
                   .evaluate(
                       1, [] {}, false)
                   .storage);
}

// The light that a round turns reaches a cube map, too.
TEST(Renderer, TurnsTheCubeMapOfLight) {
  const formats::Pack sphere = tests::spherePack(3, 12);
  const formats::Pack pack = tests::madePixelPack(sphere.mesh);
  MadeReport made(sphere);
  made.addVariant("pixels", Json::object(), pack);
  const Plan plan = made.plan();
  const Sources sources = made.sources();
  Renderer renderer(plan, {cameraFrom({0, 0, 4}, {0, 0, 0}, 40), cameraFrom({0, 0, 4}, {0, 0, 0}, 40)},
                    sources);
  transport::LightNeeds needs{1};
  needs.cube_side = 8;
  const Renderer::Conditions conditions = renderer.conditions(pack.mesh, needs, 0);
  EXPECT_EQ(conditions.turnedCube(Eigen::Matrix3d::Identity()), conditions.cube);
  const auto turned = conditions.turnedCube(
      Eigen::AngleAxisd(std::numbers::pi / 2, transport::Vec3::UnitY()).toRotationMatrix());
  EXPECT_NE(turned, conditions.cube);
  needs.cube_side = 0;
  EXPECT_FALSE(renderer.conditions(pack.mesh, needs, 0).cube_of);
}

// Without the times of the machine, and with what the plan said.
TEST(Evaluation, SaysTheSameTwice) {
  MadeReport made(truth());
  made.addVariant("b", {{"transfer.order", 3}}, madeGlossyPack(3))["player"] = {
      {"light_change_ms", 3}, {"frame_ms", 7.5}, {"gpu_frame_ms", 5}, {"gpu_bytes", 1}};
  made.addVariant("a", {{"transfer.order", 2}}, madeGlossyPack(2));
  made.json["failed"].push_back({{"name", "c"}, {"stage", "transfer"}, {"reason", "no"}});
  const Plan plan = made.plan();
  const auto timeless = [&](Json report) {
    EXPECT_FALSE(report["pareto"].empty());
    EXPECT_EQ(report["pareto"], report["fronts"]["frame_ms"]);
    report.erase("pareto");
    report["fronts"].erase("frame_ms");
    for (Json& variant : report["variants"]) {
      EXPECT_DOUBLE_EQ(variant["frame_ms"].get<double>(),
                       variant["cpu"]["light_change_ms"]["median"].get<double>() +
                           variant["cpu"]["view_change_ms"]["median"].get<double>());
      variant.erase("frame_ms");
      variant.erase("cpu");
    }
    return report;
  };
  const Json first = timeless(reportJson(plan, evaluate(made))),
             second = timeless(reportJson(plan, evaluate(made)));
  EXPECT_EQ(first, second);
  EXPECT_EQ(first["variants"][0]["gl"]["light_change_ms"]["median"], 3);
  EXPECT_EQ(first["variants"][0]["gl"]["frame_ms"]["high"], 7.5);
  EXPECT_EQ(first["variants"][0]["gl"]["gpu_frame_ms"]["low"], 5);
  EXPECT_FALSE(first["variants"][0]["gl"].contains("gpu_light_change_ms"));
  EXPECT_TRUE(first["variants"][1]["gl"].is_null());
  EXPECT_EQ(first["variants"][0]["bake_s"], 1.5 + 9);
  EXPECT_EQ(first["variants"][0]["bake_cpu_s"], 2.5 + 18);
  EXPECT_EQ(first["fronts"]["bake_s"], Json({"a", "b"}));
  EXPECT_EQ(first["failed"][0]["reason"], "no");
}

TEST(Evaluation, RefusesWhatDoesNotFit) {
  const auto messageOf = [](const MadeReport& made) {
    try {
      evaluate(made);
    } catch (const Error& error) {
      return error.paragraph();
    }
    return std::string("nothing");
  };
  MadeReport made(truth());
  made.addVariant("far", Json::object(), truth());
  for (auto& position : made.packs["pack0.glb"].mesh.positions) position[0] += 100;
  EXPECT_THAT(messageOf(made), testing::HasSubstr("no pixel"));

  made = MadeReport(truth());
  made.addVariant("good", Json::object(), truth());
  made.json["views"][1]["frame"]["width"] = 95;
  EXPECT_THAT(messageOf(made),
              testing::AllOf(testing::HasSubstr("truth-1.exr"), testing::HasSubstr("95 × 72")));
  made.json["views"][1]["frame"]["width"] = 96;
  made.metadata["truth-1.exr"].erase("bakelight:eye");
  EXPECT_THAT(messageOf(made), testing::HasSubstr("bakelight:eye"));
  made.metadata["truth-1.exr"]["bakelight:eye"] = "1 2";
  EXPECT_THAT(messageOf(made), testing::HasSubstr("3 numbers"));
}

}  // namespace
}  // namespace bakelight::report
