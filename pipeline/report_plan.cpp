// From a finished sweep to what is read by the tool that compares its variants.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "formats/error.h"
#include "pipeline/sweep.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;
using formats::Json;
namespace {

class PlanWriter {
 public:
  PlanWriter(const Sweep& sweep, const std::vector<Outcome>& outcomes, Memo& memo)
      : sweep_(sweep), outcomes_(outcomes), memo_(memo) {}

  Json views() {
    Json views = Json::array();
    for (std::size_t i = 0; i < sweep_.views.size(); ++i) {
      const View& view = sweep_.views[i];
      views.push_back({{"name", view.name},
                       {"light", view.light},
                       {"camera", view.camera},
                       {"environment", fileEntry(view.environment)},
                       {"lights", fileEntry(view.lights)},
                       {"frame", view.frame},
                       {"reference", made(sweep_.truths[i], sweep_.reference_output)}});
      if (!view.windowing.is_null()) views.back()["windowing"] = view.windowing;
    }
    return views;
  }

  void addTo(Json& plan, const SweptVariant& swept) {
    if (const std::optional<TaskIndex> failed = whatFailed(swept.pack)) {
      plan["failed"].push_back({{"name", swept.variant.name},
                                {"stage", sweep_.graph.tasks[*failed].stage},
                                {"reason", outcomes_[*failed].reason}});
      return;
    }
    Json entry = {{"name", swept.variant.name},
                  {"parameters", parametersOf(swept.variant)},
                  {"pack", made(swept.pack, sweep_.pack_output)},
                  {"stages", Json::array()},
                  {"left_out", Json::array()},
                  {"player", nullptr},
                  {"chain", chainOf(swept)}};
    for (const TaskIndex task : neededFor(swept.pack)) {
      if (outcomes_[task].entry) entry["stages"].push_back(costOf(task));
      for (const Omission& omission : outcomes_[task].omissions) {
        entry["left_out"].push_back(toJson(omission));
        entry["left_out"].back()["stage"] = sweep_.graph.tasks[task].stage;
      }
    }
    if (swept.frame && outcomes_[*swept.frame].entry)
      entry["player"] = outcomes_[*swept.frame].entry->run.stats;
    plan["variants"].push_back(std::move(entry));
  }

 private:
  Json fileEntry(const fs::path& path) {
    if (path.empty()) return nullptr;
    return {{"path", fs::absolute(path).lexically_normal().string()}, {"hash", memo_.hashOf(path)}};
  }

  Json made(TaskIndex task, const std::string& port) const {
    const CacheEntry& entry = *outcomes_[task].entry;
    const CachedFile& file = entry.outputs.at(port);
    return {{"path", fs::absolute(entry.pathOf(file)).lexically_normal().string()}, {"hash", file.hash}};
  }

  // The task itself last.
  std::set<TaskIndex> neededFor(TaskIndex task) const {
    std::set<TaskIndex> needed = {task};
    const bool omitted = outcomes_[task].status == StageStatus::kLeftOut;
    for (const TaskIndex maker : omitted ? sweep_.graph.judgesOf(task) : sweep_.graph.makersOf(task))
      needed.merge(neededFor(maker));
    return needed;
  }

  std::optional<TaskIndex> whatFailed(TaskIndex task) const {
    if (outcomes_[task].entry) return {};
    for (const TaskIndex needed : neededFor(task))
      if (outcomes_[needed].status == StageStatus::kFailed) return needed;
    return task;
  }

  Json costOf(TaskIndex task) const {
    const CacheEntry& entry = *outcomes_[task].entry;
    std::uint64_t bytes = 0;
    for (const auto& [port, file] : entry.outputs) bytes += file.bytes;
    return {{"stage", sweep_.graph.tasks[task].stage},
            {"wall_s", entry.run.wall_s},
            {"cpu_s", entry.run.cpu_s},
            {"peak_memory_bytes", entry.run.peak_memory_bytes},
            {"bytes", bytes},
            {"warnings", entry.run.warnings}};
  }

  Json chainOf(const SweptVariant& swept) const {
    Json chain = Json::array();
    for (const Link& link : swept.chain) {
      const bool traced = !link.references.empty();
      const bool there = traced
                             ? std::all_of(link.references.begin(), link.references.end(),
                                           [&](TaskIndex task) { return outcomes_[task].entry.has_value(); })
                             : outcomes_[link.pack].entry.has_value();
      // The next link would be charged with this one's cause, too: rather no causes than wrong ones.
      if (!there) return Json::array();
      Json entry = {{"cause", link.cause}};
      for (const TaskIndex reference : link.references)
        entry["references"].push_back(made(reference, sweep_.reference_output));
      if (!traced) entry["pack"] = made(link.pack, sweep_.pack_output);
      chain.push_back(std::move(entry));
    }
    const bool omits = std::any_of(sweep_.graph.tasks.begin(), sweep_.graph.tasks.end(),
                                   [&](const Task& task) { return !task.rules.empty(); });
    if (omits) chain.push_back({{"cause", "left_out"}, {"pack", made(swept.pack, sweep_.pack_output)}});
    return chain;
  }

  const Sweep& sweep_;
  const std::vector<Outcome>& outcomes_;
  Memo& memo_;
};

}  // namespace

Json reportPlan(const std::string& asset, const Sweep& sweep, const std::vector<Outcome>& outcomes,
                Memo& memo) {
  for (std::size_t i = 0; i < sweep.views.size(); ++i)
    if (!outcomes[sweep.truths[i]].entry)
      throw badInput({}, "the reference of the view " + sweep.views[i].name +
                             " could not be made: " + outcomes[sweep.truths[i]].reason);
  PlanWriter writer(sweep, outcomes, memo);
  Json plan = {
      {"asset", asset}, {"views", writer.views()}, {"variants", Json::array()}, {"failed", Json::array()}};
  for (const SweptVariant& swept : sweep.variants) writer.addTo(plan, swept);
  return plan;
}

}  // namespace bakelight::pipeline
