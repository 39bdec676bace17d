// What a scene does not need, by measurement: rules of the recipe judged by figures that stages before have
// told.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "formats/json.h"
#include "pipeline/cache.h"
#include "pipeline/graph.h"

namespace bakelight::pipeline {

// Something that is left out, and why.
struct Omission {
  std::string what;    // "bounces"
  std::string figure;  // "survey.bounce_energy"
  double value = 0, threshold = 0;
  double error = 0;  // relative, that it adds; as the rule's error figure estimates it
};

// Why the whole task is omitted, if a rule does: the first that applies. `entries`: what each task made, by index;
// those of graph.judgesOf(task) must be there. Throws as settle().
std::optional<Omission> omissionOf(const Graph& graph, TaskIndex task,
                                   const std::vector<std::optional<CacheEntry>>& entries);

// A kept task's parameters after figures and rules, and which rules applied.
struct SettledTask {
  formats::Json parameters;
  std::vector<Omission> omissions;
};

// `entries`: what each task made, by index; those of the task's figures (of its rules and of measured parameters) must be there. Throws
// Error(kBadInput) naming the recipe if the stage's stats have no such number.
SettledTask settle(const Graph& graph, TaskIndex task, const std::vector<std::optional<CacheEntry>>& entries);

formats::Json toJson(const Omission& omission);
// "bounces: survey.bounce_energy is 0.0012, at most 0.005"
std::string text(const Omission& omission);

}  // namespace bakelight::pipeline
