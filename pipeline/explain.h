// Whether a stage is up to date, and if not, why: decided here, once, for `run`, `run --dry-run` and
// `explain`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/cache.h"
#include "pipeline/graph.h"
#include "pipeline/ingredients.h"
#include "pipeline/leave_out.h"
#include "pipeline/output_folder.h"
#include "pipeline/record.h"
#include "pipeline/toolbox.h"

namespace bakelight::pipeline {

struct Verdict {
  Ingredients ingredients;
  std::vector<Omission> omissions;
  std::optional<CacheEntry> entry;  // what the cache has for these ingredients
  std::vector<std::string>
      changes;  // since the outputs in the folder were made: "order changed from 5 to 4", "never run"
  std::vector<std::string>
      misplaced;  // outputs in the folder that are not as in `entry`: "mesh.ply was edited"

  bool mustRun() const { return !entry; }
  bool upToDate() const { return entry && changes.empty() && misplaced.empty(); }
};

class Explainer {
 public:
  Explainer(const Graph& graph, Toolbox& tools, const Cache& cache, const OutputFolder& out, const Disk& disk,
            Memo& memo, const std::vector<PastRecord>& past);

  // `entries`: what each task made, by index; those of the task's makers must be there, but of those that are
  // omitted: the input is then left out. Hashes input files. Throws Error(kBadInput) if an input cannot be read,
  // and as settle().
  Verdict judge(TaskIndex task, const std::vector<std::optional<CacheEntry>>& entries) const;

  // Whether leaving out all of `task` by measurement is something new: the folder has its outputs, or the record
  // does not say so.
  bool newlyLeftOut(TaskIndex task, const std::string& reason) const;

  // Changes that can be told while the inputs are not made yet: of parameters and of the tool.
  std::vector<std::string> changesBesidesInputs(TaskIndex task) const;

 private:
  Ingredients withoutInputs(const Task& task) const;
  Ingredients ingredientsOf(const Task& task, formats::Json parameters,
                            const std::vector<std::optional<CacheEntry>>& entries) const;
  std::vector<std::string> changesSince(const PastRecord::Stage& past, const Task& task,
                                        const Verdict& verdict, const std::string& damage) const;

  const Graph& graph_;
  Toolbox& tools_;
  const Cache& cache_;
  const OutputFolder& out_;
  const Disk& disk_;
  Memo& memo_;
  const std::vector<PastRecord>& past_;  // by asset
};

// One line on a stage of `bakelight explain` or `run --dry-run`.
struct Explanation {
  TaskIndex task = 0;
  enum class State {
    kUpToDate,
    kRestore,
    kFromCache,
    kRun,
    kWaits,
    kLeftOut,
    kLeaveOut
  } state = State::kUpToDate;
  std::string reason;
};
const char* nameOf(Explanation::State state);  // "up to date", "would run", ...

// For each task, as far as can be told without running anything: what waits for a stage that must run is said
// to wait.
std::vector<Explanation> explain(const Graph& graph, const Explainer& explainer);

}  // namespace bakelight::pipeline
