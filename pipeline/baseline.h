// `bakelight baseline save|check`: what the stages of an asset make, kept in a folder, and compared with what
// they make later. See docs/BASELINE.md.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "formats/compare.h"
#include "formats/json.h"
#include "pipeline/baseline_file.h"
#include "pipeline/build.h"
#include "pipeline/cache.h"
#include "pipeline/disk.h"
#include "pipeline/graph.h"
#include "pipeline/runner.h"
#include "pipeline/toolbox.h"

namespace bakelight::pipeline {

// What a finished build made of one asset.
struct MadeStage {
  std::string stage, tool, execution_path;
  formats::Json parameters;
  std::map<std::string, std::string> kinds;  // of the outputs, by port
  CacheEntry entry;
};
struct MadeAsset {
  std::string name, recipe;
  std::vector<MadeStage> stages;                     // those that were not left out, in the graph's order
  std::map<std::string, std::string> left_out = {};  // the others: why
};

// Throws Error(kBadInput) if a stage failed or was not run: a part is no baseline.
MadeAsset madeAsset(const Graph& graph, std::size_t asset, const BuildResult& result, Toolbox& tools);

// baseline/ beside asset.json; beside a mesh without one, <stem of the mesh>.baseline/.
std::filesystem::path baselineFolder(const Asset& asset);

// Copies all outputs into `folder`, whole or not at all: an old baseline there is replaced once the new one
// is complete. Throws Error(kCannotWrite); Error(kBadInput) if no stage has an output, or if `folder` holds
// something that is not a baseline.
void saveBaseline(const MadeAsset& made, const std::filesystem::path& folder, Disk& disk);

// How far apart two files of a kind with limits are: file, reference. Only measures; throws Error if one
// cannot be read.
using Comparer = std::function<formats::Comparison(const std::string& kind, const std::filesystem::path& file,
                                                   const std::filesystem::path& reference,
                                                   const formats::CompareLimits& limits)>;
// Asks the tool `compare` of `tools`, which knows all formats. Its answer goes through a file in `scratch`.
Comparer compareTool(const std::filesystem::path& tools, const std::filesystem::path& scratch, Runner& runner,
                     Disk& disk);

// One line of the table.
struct BaselineRow {
  std::string stage, output, kind;
  std::string figure, measured, limit;
  bool passes = true;
};

struct BaselineReport {
  std::vector<BaselineRow> rows;
  std::vector<std::string> notes;  // that explain, but are no differences: "transfer: order changed ..."
  std::size_t compared_outputs = 0;

  std::size_t differenceCount() const;
  bool passes() const;  // false if no output was compared
  int exitStatus() const { return passes() ? 0 : 1; }
};

// A stage or an output that only one side has is a difference. Throws Error or ProblemsFound (exit status 2)
// if there is no baseline, it is damaged, or of another recipe.
BaselineReport checkBaseline(const MadeAsset& made, const std::filesystem::path& folder, const Disk& disk,
                             const Comparer& compare);

// Notes, the table, and one line that says how it ended.
void print(const BaselineReport& report, std::ostream& out);

}  // namespace bakelight::pipeline
