#include "pipeline/leave_out.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "formats/error.h"

namespace bakelight::pipeline {
using formats::Json;
namespace {

double figureOf(const Graph& graph, const Task& task, const Wire& figure, const CacheEntry& entry,
                const std::string& key = "leave_out") {
  const Json& stats = entry.run.stats;
  if (!stats.contains(figure.port) || !stats[figure.port].is_number())
    throw badInput({graph.assets[task.asset].recipe + " (recipe)", "", "/stages/" + task.stage + "/" + key},
                   "the stage " + figure.stage + " tells no figure \"" + figure.port + "\"",
                   "a number in its stats.json");
  return stats[figure.port].get<double>();
}

// Of `rule`, if its figure is small enough.
std::optional<Omission> judged(const Graph& graph, const Task& task, const TaskRule& rule,
                               const std::vector<std::optional<CacheEntry>>& entries) {
  const double value = figureOf(graph, task, rule.rule.figure, *entries.at(rule.figure_maker));
  const double error = figureOf(graph, task, rule.rule.error, *entries.at(rule.error_maker));
  if (!(value <= rule.rule.at_most)) return {};
  return Omission{rule.rule.what, rule.rule.figure.text(), value, rule.rule.at_most, error};
}

// Whether `rule` changes anything.
bool apply(const LeaveOutRule& rule, Json& parameters) {
  bool changed = false;
  for (const auto& [parameter, values] : rule.set) {
    if (!parameters.contains(parameter)) continue;
    auto instead = rule.changed(parameter, parameters[parameter]);
    if (!instead) continue;
    parameters[parameter] = std::move(*instead);
    changed = true;
  }
  return changed;
}

}  // namespace

std::optional<Omission> omissionOf(const Graph& graph, TaskIndex index,
                                   const std::vector<std::optional<CacheEntry>>& entries) {
  const Task& task = graph.tasks[index];
  for (const TaskRule& rule : task.rules)
    if (rule.rule.omit)
      if (auto omission = judged(graph, task, rule, entries)) return omission;
  return {};
}

SettledTask settle(const Graph& graph, TaskIndex index,
                   const std::vector<std::optional<CacheEntry>>& entries) {
  const Task& task = graph.tasks[index];
  SettledTask settled{task.parameters, {}};
  for (const MeasuredParameter& parameter : task.measured)
    settled.parameters[parameter.name] =
        figureOf(graph, task, parameter.figure, *entries.at(parameter.maker), "parameters/" + parameter.name);
  for (const TaskRule& rule : task.rules) {
    if (rule.rule.omit) continue;
    auto omission = judged(graph, task, rule, entries);
    if (omission && apply(rule.rule, settled.parameters)) settled.omissions.push_back(std::move(*omission));
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
