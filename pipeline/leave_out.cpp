#include "pipeline/leave_out.h"

#include <nlohmann/json.hpp>

#include "formats/error.h"

namespace bakelight::pipeline {
using formats::Json;
namespace {

double figureOf(const Graph& graph, const Task& task, const Wire& figure, const CacheEntry& entry) {
  const Json& stats = entry.run.stats;
  if (!stats.contains(figure.port) || !stats[figure.port].is_number())
    throw badInput(
        {graph.assets[task.asset].recipe + " (recipe)", "", "/stages/" + task.stage + "/leave_out"},
        "the stage " + figure.stage + " tells no figure \"" + figure.port + "\"",
        "a number in its stats.json");
  return stats[figure.port].get<double>();
}

// Whether `rule` changes anything.
bool apply(const LeaveOutRule& rule, Json& parameters) {
  bool changed = false;
  for (const auto& [parameter, values] : rule.set) {
    if (!parameters.contains(parameter) || !parameters[parameter].is_string()) continue;
    const auto instead = values.find(parameters[parameter].get<std::string>());
    if (instead == values.end()) continue;
    parameters[parameter] = instead->second;
    changed = true;
  }
  return changed;
}

}  // namespace

SettledTask settle(const Graph& graph, TaskIndex index,
                   const std::vector<std::optional<CacheEntry>>& entries) {
  const Task& task = graph.tasks[index];
  SettledTask settled{task.parameters, {}};
  for (const TaskRule& rule : task.rules) {
    const double value = figureOf(graph, task, rule.rule.figure, *entries.at(rule.figure_maker));
    const double error = figureOf(graph, task, rule.rule.error, *entries.at(rule.error_maker));
    if (value <= rule.rule.at_most && apply(rule.rule, settled.parameters))
      settled.omissions.push_back({rule.rule.what, rule.rule.figure.text(), value, rule.rule.at_most, error});
  }
  return settled;
}

Json toJson(const Omission& omission) {
  return {{"what", omission.what},
          {"figure", omission.figure},
          {"value", omission.value},
          {"threshold", omission.threshold},
          {"error", omission.error}};
}

std::string text(const Omission& omission) {
  return omission.what + ": " + omission.figure + " is " + Json(omission.value).dump() + ", at most " +
         Json(omission.threshold).dump();
}

}  // namespace bakelight::pipeline
