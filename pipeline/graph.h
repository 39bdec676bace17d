// All stages of all assets, wired, with every parameter settled and checked: what the scheduler works
// through.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
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
  std::optional<TaskIndex> maker;   // nothing: a file of the asset
  std::string port;                 // the maker's output, or the asset's port
  std::filesystem::path file = {};  // of the asset
};

// One stage of one asset.
struct Task {
  std::size_t asset = 0;  // into Graph::assets
  std::string stage, tool;
  std::map<std::string, Input> inputs = {};              // by port of the tool
  std::map<std::string, std::string> outputs = {};       // file name by port
  std::map<std::string, std::string> deliverables = {};  // name by output port; only what is asked for
  formats::Json parameters = formats::Json::object();    // all of the tool's, canonical
  std::string left_out = "";                             // why it does not run; "" if it may
};

struct Graph {
  std::vector<Asset> assets;
  std::vector<Task> tasks = {};  // makers before users

  std::string nameOf(TaskIndex task) const;  // "bunny transfer"
};

// A parameter given on the command line, for all assets.
struct Setting {
  std::string stage, parameter, value;
  std::string option;  // as it was typed, for errors
};
// From "transfer.order=5". Throws Error(kUsage).
Setting parseSetting(const std::string& text);

struct GraphOptions {
  std::vector<Setting> settings = {};
  std::vector<std::string> deliver = {};  // instead of what the assets say; empty: as they say
};

inline constexpr const char* kNotNeeded = "nothing delivered needs it";

// Parameters: the tool's defaults, then the recipe's, then asset.json's, then the settings. Checked against
// what the tools say of themselves: stage, parameter and port names, types, ranges, kinds of files, required
// inputs. Every mistake is put into `problems`, with file and JSON pointer; the graph is whole only if there
// was none.
Graph makeGraph(std::vector<Asset> assets, RecipeBook& recipes, Toolbox& tools, const GraphOptions& options,
                Problems& problems);

}  // namespace bakelight::pipeline
