// All stages of all assets, wired, with every parameter settled and checked: what the scheduler works
// through.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "formats/json.h"
#include "pipeline/asset.h"
#include "pipeline/problems.h"
#include "pipeline/recipe.h"
#include "pipeline/toolbox.h"

namespace bakelight::pipeline {

using TaskIndex = std::size_t;  // into Graph::tasks

// Where a task's input comes from.
struct Input {
  std::optional<TaskIndex> maker = {};  // nothing: a file of the asset
  std::string port;                     // the maker's output, or the asset's port
  std::filesystem::path file = {};      // of the asset
  // Of the asset, too, but no file: the text that is written for the tool to read. Null: there is a file.
  formats::Json value = {};
};
// What the asset supplies, for a tool's input of those `parts` (formats::PortDescription); nothing if it has
// no such port.
std::optional<Input> inputFrom(const Asset& asset, const std::string& port,
                               const std::vector<std::string>& parts);

// A rule of the recipe that may apply to a task, see LeaveOutRule.
struct TaskRule {
  LeaveOutRule rule;
  TaskIndex figure_maker = 0, error_maker = 0;
};

// A parameter that a figure of another stage settles.
struct MeasuredParameter {
  std::string name;
  Wire figure;
  TaskIndex maker = 0;
};

// One stage of one asset.
struct Task {
  std::size_t asset = 0;  // into Graph::assets
  std::string stage, tool;
  std::map<std::string, Input> inputs = {};              // by port of the tool
  std::map<std::string, std::string> outputs = {};       // file name by port
  std::map<std::string, std::string> deliverables = {};  // name by output port; only what is asked for
  formats::Json parameters = formats::Json::object();    // all of the tool's, canonical
  std::vector<TaskRule> rules = {};                      // in the recipe's order; the makers are done before
  std::vector<MeasuredParameter> measured = {};          // the makers are done before
  std::string left_out = "";                             // why it does not run; "" if it may
  bool published = true;                                 // else the outputs stay in the cache
};

struct Graph {
  std::vector<Asset> assets;
  std::vector<Task> tasks = {};  // makers before users

  std::string nameOf(TaskIndex task) const;  // "bunny transfer"
  // What has to be done before: makers of inputs, and of the figures of rules and parameters.
  std::set<TaskIndex> makersOf(TaskIndex task) const;
  // Of these, makers of the figures by which rules may omit the whole task: done before its inputs are made.
  std::set<TaskIndex> judgesOf(TaskIndex task) const;
  bool mayBeOmitted(TaskIndex task) const { return !judgesOf(task).empty(); }
};

struct GraphOptions {
  std::vector<Setting> settings = {};
  std::vector<std::string> deliver = {};  // instead of what the assets say; empty: as they say
  bool keep_all = false;                  // nothing is left out by a measured figure
};

inline constexpr const char* kNotNeeded = "nothing delivered needs it";

// All parameters of a tool, canonical.
formats::Json defaultParameters(const formats::ToolDescription& tool);

// Parameters: the tool's defaults, then the recipe's (of which some are those of another stage, or a figure of one), then
// asset.json's, then the settings. Checked against
// what the tools say of themselves: stage, parameter and port names, types, ranges, kinds of files, required
// inputs. Every mistake is put into `problems`, with file and JSON pointer; the graph is whole only if there
// was none.
Graph makeGraph(std::vector<Asset> assets, RecipeBook& recipes, Toolbox& tools, const GraphOptions& options,
                Problems& problems);

}  // namespace bakelight::pipeline
