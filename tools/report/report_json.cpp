#include "tools/report/report_json.h"

#include <nlohmann/json.hpp>

namespace bakelight::report {
namespace {

using formats::Json;

Json jsonOf(const Spread& spread) {
  return {{"median", spread.median}, {"low", spread.low}, {"high", spread.high}};
}

Json jsonOf(const ErrorFigures& errors) {
  return {{"rel_rmse", errors.rel_rmse},
          {"p99", errors.p99},
          {"flip", errors.flip},
          {"coverage_error", errors.coverage_error}};
}

Json jsonOf(const StageFigures& stage) {
  return {{"stage", stage.stage}, {"wall_s", stage.wall_s},
          {"cpu_s", stage.cpu_s}, {"peak_memory_bytes", stage.peak_memory_bytes},
          {"bytes", stage.bytes}, {"warnings", stage.warnings}};
}

Json jsonOf(const LeftOut& left_out, const VariantFigures& figures) {
  Json json = {{"stage", left_out.stage},
               {"what", left_out.what},
               {"figure", left_out.figure},
               {"value", left_out.value},
               {"threshold", left_out.threshold}};
  json["error"] = left_out.error ? Json(*left_out.error) : Json();
  if (const auto measured = figures.leftOutError()) json["measured_error"] = *measured;
  return json;
}

Json glOf(const PlanVariant& variant) {
  if (!variant.gl) return nullptr;
  Json json = {{"light_change_ms", jsonOf(variant.gl->light_change_ms)},
               {"frame_ms", jsonOf(variant.gl->frame_ms)}};
  if (const auto& gpu = variant.gl->gpu_light_change_ms) json["gpu_light_change_ms"] = jsonOf(*gpu);
  if (const auto& gpu = variant.gl->gpu_frame_ms) json["gpu_frame_ms"] = jsonOf(*gpu);
  return json;
}

Json variantOf(const Plan& plan, const PlanVariant& variant, const VariantFigures& figures) {
  Json json = jsonOf(figures.errors);
  json["name"] = variant.name;
  json["parameters"] = variant.parameters;
  json["bake_s"] = figures.bake_s;
  json["bake_cpu_s"] = figures.bake_cpu_s;
  json["bytes"] = figures.bytes;
  json["vertices"] = figures.vertices;
  json["frame_ms"] = figures.frame_ms();
  json["cpu"] = {{"light_change_ms", jsonOf(figures.light_change_ms)},
                 {"view_change_ms", jsonOf(figures.view_change_ms)}};
  json["gl"] = glOf(variant);
  json["views"] = Json::array();
  for (std::size_t view = 0; view < plan.views.size(); ++view) {
    json["views"].push_back(jsonOf(figures.view_errors[view]));
    json["views"].back()["name"] = plan.views[view].name;
  }
  json["causes"] = Json::array();
  for (const CauseError& cause : figures.causes)
    json["causes"].push_back({{"cause", cause.cause}, {"rel_rmse", cause.rel_rmse}});
  for (const LightWindow& window : figures.windows)
    json["windows"].push_back({{"light", window.light},
                               {"lambda", window.choice.lambda},
                               {"displayed_error", window.choice.error.displayed},
                               {"displayed_error_without", window.choice.without.displayed},
                               {"rel_rmse", window.choice.error.radiance},
                               {"rel_rmse_without", window.choice.without.radiance}});
  json["stages"] = Json::array();
  for (const StageFigures& stage : variant.stages) json["stages"].push_back(jsonOf(stage));
  json["left_out"] = Json::array();
  for (const LeftOut& left_out : variant.left_out) json["left_out"].push_back(jsonOf(left_out, figures));
  return json;
}

// Each omission once, with the variants that have it.
Json leftOutOfAll(const Json& variants) {
  Json all = Json::array();
  for (const Json& variant : variants)
    for (const Json& left_out : variant.at("left_out")) {
      Json* found = nullptr;
      for (Json& known : all) {
        Json without_names = known;
        without_names.erase("variants");
        if (without_names == left_out) found = &known;
      }
      if (!found) {
        all.push_back(left_out);
        found = &all.back();
        (*found)["variants"] = Json::array();
      }
      (*found)["variants"].push_back(variant.at("name"));
    }
  return all;
}

Json storageOf(const Plan& plan, const StorageFigures& storage) {
  Json json = {{"rows", storage.rows},
               {"entries", storage.entries},
               {"dense_bytes", storage.dense_bytes},
               {"methods", Json::array()}};
  const auto byView = [&](const std::vector<double>& errors) {
    Json views = Json::object();
    for (std::size_t view = 0; view < plan.views.size(); ++view) views[plan.views[view].name] = errors[view];
    return views;
  };
  for (const StorageMethod& method : storage.methods)
    json["methods"].push_back({{"name", method.name},
                               {"parameters", method.parameters},
                               {"share", method.share},
                               {"bytes", method.bytes},
                               {"operations", method.operations},
                               {"product_ms", jsonOf(method.product_ms)},
                               {"incident_error", rootMeanSquare(method.incident_errors)},
                               {"incident_errors", byView(method.incident_errors)},
                               {"picture_error", rootMeanSquare(method.picture_errors)},
                               {"picture_errors", byView(method.picture_errors)}});
  return json;
}

Json namesOf(const std::vector<std::size_t>& front, const Plan& plan) {
  Json names = Json::array();
  for (const std::size_t variant : front) names.push_back(plan.variants[variant].name);
  return names;
}

}  // namespace

Json reportJson(const Plan& plan, const Evaluation& evaluation) {
  Json json = {{"asset", plan.asset},
               {"views", Json::array()},
               {"variants", Json::array()},
               {"failed", Json::array()}};
  for (std::size_t view = 0; view < plan.views.size(); ++view)
    json["views"].push_back({{"name", plan.views[view].name},
                             {"light", plan.views[view].light},
                             {"camera", plan.views[view].camera},
                             {"noise", evaluation.noise[view]}});
  for (std::size_t v = 0; v < plan.variants.size(); ++v)
    json["variants"].push_back(variantOf(plan, plan.variants[v], evaluation.variants[v]));
  json["left_out"] = leftOutOfAll(json["variants"]);
  json["fronts"] = {{"frame_ms", namesOf(evaluation.fronts.frame_ms, plan)},
                    {"bytes", namesOf(evaluation.fronts.bytes, plan)},
                    {"bake_s", namesOf(evaluation.fronts.bake_s, plan)}};
  json["pareto"] = json["fronts"]["frame_ms"];
  if (evaluation.storage) json["storage"] = storageOf(plan, *evaluation.storage);
  for (const FailedVariant& failed : plan.failed)
    json["failed"].push_back({{"name", failed.name}, {"stage", failed.stage}, {"reason", failed.reason}});
  return json;
}

}  // namespace bakelight::report
