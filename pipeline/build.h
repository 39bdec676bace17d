// Works through a graph: what is up to date is left alone, what the cache has is taken from it, the rest is
// run, several stages at once within one budget of cores.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pipeline/cache.h"
#include "pipeline/demand.h"
#include "pipeline/explain.h"
#include "pipeline/graph.h"
#include "pipeline/output_folder.h"
#include "pipeline/record.h"
#include "pipeline/runner.h"
#include "pipeline/toolbox.h"

namespace bakelight::pipeline {

// Is told what happens, as it happens.
class BuildObserver {
 public:
  virtual ~BuildObserver() = default;
  virtual void started(TaskIndex task) = 0;
  virtual void progressed(TaskIndex task, const ToolProgress& progress) = 0;
  virtual void said(TaskIndex task,
                    const std::string& line) = 0;  // a warning, or a line that is not of the contract
  virtual void settled(TaskIndex task, const Outcome& outcome) = 0;
};

struct BuildSettings {
  std::size_t jobs = 1;   // stages at once, >= 1
  std::size_t cores = 1;  // handed out among them as --threads, >= 1
};

struct BuildResult {
  std::vector<Outcome> outcomes;         // by task
  std::vector<Error> unwritten_records;  // records that could not be written
  bool interrupted = false;

  // Of the first stage that failed, 130 if interrupted, 0 if all went well.
  int exitStatus() const;
};

class Build {
 public:
  struct Parts {
    const Graph& graph;
    Toolbox& tools;
    Cache& cache;
    OutputFolder& out;
    Memo& memo;
    Disk& disk;
    Runner& runner;
    BuildObserver& observer;
  };
  // `past`: by asset.
  Build(const Parts& parts, const std::vector<PastRecord>& past, BuildSettings settings);

  // Never throws for what goes wrong in a stage: that one fails, what needs it is not run, all others go on.
  // An interruption stops the running tools, removes what they began, and leaves the rest for the next time.
  BuildResult run();

 private:
  struct Running {
    std::string key;
    Ingredients ingredients;
    std::vector<Omission> omissions;
    std::string reason;
    std::filesystem::path folder = {};  // that it writes into
    std::size_t threads = 1;
  };

  void prepare();
  void startWhatIsReady();
  void consider(TaskIndex task);
  void decide(TaskIndex task);
  void launch(TaskIndex task, Verdict verdict);
  std::vector<std::string> commandFor(TaskIndex task, const Running& running) const;
  std::size_t threadsForNext() const;
  void take(const Event& event);
  void finish(TaskIndex task, const ToolFinished& finished);
  void accept(TaskIndex task, const Running& running, const ToolFinished& finished);
  Error failureOf(TaskIndex task, const Running& running, const ToolFinished& finished) const;
  void interrupt();

  void settle(TaskIndex task, Outcome outcome);
  void settleFailed(TaskIndex task, const Error& error, int exit_status);
  void settleNotRun(TaskIndex task, const std::string& reason);
  void settleLeftOut(TaskIndex task, const std::string& reason, std::vector<Omission> omissions);
  void settleUnneeded(TaskIndex task);
  std::optional<std::string> reasonNotToRunAfter(TaskIndex maker) const;
  void advance(TaskIndex task);
  void writeRecord(std::size_t asset);
  std::string withPublicPaths(TaskIndex task, const Running& running, std::string text) const;

  Parts parts_;
  const Graph& graph_;
  const std::vector<PastRecord>& past_;
  const BuildSettings settings_;
  Explainer explainer_;
  Demand demand_;

  BuildResult result_;
  std::vector<std::optional<CacheEntry>> entries_;  // by task, once made
  std::vector<bool> settled_;                       // by task
  std::vector<std::size_t> open_stages_;            // by asset
  std::set<TaskIndex> ready_;
  std::map<TaskIndex, Running> running_;
  std::map<std::string, std::vector<TaskIndex>>
      same_key_;  // wait for a running task of another asset to make their entry
  std::size_t free_cores_ = 0;
};

}  // namespace bakelight::pipeline
