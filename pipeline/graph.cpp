#include "pipeline/graph.h"

#include <algorithm>
#include <set>
#include <utility>

#include "formats/error.h"
#include "pipeline/json_object.h"

namespace bakelight::pipeline {
using formats::Json;
using formats::ToolDescription;
namespace {

std::string at(const std::string& a, const std::string& b) {
  return formats::childPointer("/" + a, b);
}

// Adds one asset's stages to a graph.
class AssetStages {
 public:
  AssetStages(Graph& graph, std::size_t asset, const Recipe& recipe, Toolbox& tools,
              const GraphOptions& options, Problems& problems)
      : graph_(graph),
        asset_index_(asset),
        asset_(graph.assets[asset]),
        recipe_(recipe),
        tools_(tools),
        options_(options),
        problems_(problems) {}

  void add() {
    chooseDeliverables();
    markNeeded();
    checkOverriddenStages();
    for (const std::string& stage : stagesInOrder(recipe_))
      problems_.attempt([&] { addStage(recipe_.stages.at(stage)); });
  }

 private:
  void chooseDeliverables() {
    const std::vector<std::string> all = recipe_.deliverableNames();
    const bool from_options = !options_.deliver.empty();
    const std::vector<std::string> asked = from_options ? options_.deliver : asset_.deliver.value_or(all);
    for (std::size_t i = 0; i < asked.size(); ++i) {
      if (recipe_.deliverables.count(asked[i]) != 0) {
        delivered_.insert(asked[i]);
        continue;
      }
      const ErrorPlace place = from_options ? ErrorPlace{"--deliver " + asked[i], "", ""}
                                            : ErrorPlace{asset_.file, "", "/deliver/" + std::to_string(i)};
      problems_.add(Error(from_options ? ExitStatus::kUsage : ExitStatus::kBadInput, place,
                          "the recipe " + recipe_.name + " delivers no \"" + asked[i] + "\"",
                          "one of: " + join(all, ", "), suggestion(asked[i], all)));
    }
  }

  // What is delivered, and what that is made from.
  void markNeeded() {
    std::vector<std::string> open;
    for (const std::string& name : delivered_) open.push_back(recipe_.deliverables.at(name).stage);
    while (!open.empty()) {
      const std::string stage = open.back();
      open.pop_back();
      if (!needed_.insert(stage).second) continue;
      for (const auto& [port, wire] : recipe_.stages.at(stage).inputs)
        if (!wire.fromAsset()) open.push_back(wire.stage);
    }
  }

  void checkOverriddenStages() {
    const std::vector<std::string> stages = recipe_.stageNames();
    for (const auto& [stage, ignored] : asset_.stages.items())
      if (recipe_.stages.count(stage) == 0)
        problems_.add(badInput({asset_.file, "", at("stages", stage)},
                               "the recipe " + recipe_.name + " has no stage \"" + stage + "\"",
                               "one of: " + join(stages, ", "), suggestion(stage, stages)));
  }

  void addStage(const RecipeStage& stage) {
    Task task{.asset = asset_index_, .stage = stage.name, .tool = stage.tool};
    const bool needed = needed_.count(stage.name) != 0;
    if (!needed) task.left_out = kNotNeeded;
    wire(stage, task);
    // A tool that is not built is no obstacle to leaving its stage out.
    if (needed || tools_.has(stage.tool)) {
      const ErrorPlace place{recipe_.file, "", at("stages", stage.name) + "/tool"};
      const ToolDescription& tool = tools_.require(stage.tool, place).description;
      checkPorts(stage, tool, needed);
      task.parameters = parametersOf(stage, tool);
    }
    task_of_[stage.name] = graph_.tasks.size();
    graph_.tasks.push_back(std::move(task));
  }

  void wire(const RecipeStage& stage, Task& task) {
    for (const auto& [port, wire] : stage.inputs) {
      const auto file = asset_.files.find(wire.port);
      if (!wire.fromAsset())
        task.inputs[port] = {.maker = makerOf(wire), .port = wire.port};
      else if (file != asset_.files.end())
        task.inputs[port] = {.maker = std::nullopt, .port = wire.port, .file = file->second};
    }
    for (const auto& [port, file] : stage.outputs)
      task.outputs[port] = expand(file, asset_.name, placeOf(stage, "outputs", port));
    for (const std::string& name : delivered_)
      if (recipe_.deliverables.at(name).stage == stage.name)
        task.deliverables[recipe_.deliverables.at(name).port] = name;
  }

  // Nothing if the maker itself has a mistake, which is reported already.
  std::optional<TaskIndex> makerOf(const Wire& wire) const {
    const auto maker = task_of_.find(wire.stage);
    return maker == task_of_.end() ? std::nullopt : std::optional(maker->second);
  }

  ErrorPlace placeOf(const RecipeStage& stage, const std::string& section, const std::string& key) const {
    return {recipe_.file, "", formats::childPointer(at("stages", stage.name) + "/" + section, key)};
  }

  void checkPorts(const RecipeStage& stage, const ToolDescription& tool, bool needed) {
    for (const auto& [port, wire] : stage.inputs)
      checkPort(tool, tool.inputs, port, kindOf(wire), "input", placeOf(stage, "inputs", port));
    for (const auto& [port, file] : stage.outputs)
      checkPort(tool, tool.outputs, port, "", "output", placeOf(stage, "outputs", port));
    for (const auto& input : tool.inputs) {
      const auto wired = stage.inputs.find(input.name);
      if (!needed || !input.required) continue;
      if (wired == stage.inputs.end())
        problems_.add(badInput(placeOf(stage, "inputs", input.name), "the input is not wired",
                               "a wire, as the tool " + tool.tool + " requires it"));
      else if (wired->second.fromAsset() && asset_.files.count(wired->second.port) == 0)
        problems_.add(badInput(
            {asset_.file, "", ""},
            "the stage " + stage.name + " needs the asset's " + wired->second.port + ", and there is none",
            "\"" + wired->second.port + "\" in asset.json"));
    }
    for (const auto& output : tool.outputs)
      if (output.required && stage.outputs.count(output.name) == 0)
        problems_.add(badInput(placeOf(stage, "outputs", output.name), "the output has no file name",
                               "a file name, as the tool " + tool.tool + " always writes it"));
  }

  void checkPort(const ToolDescription& tool, const std::vector<formats::PortDescription>& ports,
                 const std::string& name, const std::string& kind, const char* direction,
                 const ErrorPlace& place) {
    std::vector<std::string> names;
    for (const auto& port : ports) {
      names.push_back(port.name);
      if (port.name != name) continue;
      if (!kind.empty() && kind != port.kind)
        problems_.add(badInput(
            place, "a file of kind \"" + kind + "\" is wired to an input of kind \"" + port.kind + "\"",
            "files of one kind"));
      return;
    }
    problems_.add(badInput(place, "the tool " + tool.tool + " has no " + direction + " \"" + name + "\"",
                           "one of: " + join(names, ", "), suggestion(name, names)));
  }

  // "" if not known (its maker is left out and not installed).
  std::string kindOf(const Wire& wire) {
    if (wire.fromAsset()) return recipe_.asset.at(wire.port).kind;
    const std::string& tool = recipe_.stages.at(wire.stage).tool;
    if (!tools_.has(tool)) return "";
    const auto* port = tools_.require(tool, {}).description.findOutput(wire.port);
    return port == nullptr ? "" : port->kind;
  }

  Json parametersOf(const RecipeStage& stage, const ToolDescription& tool) {
    Json values = Json::object();
    for (const auto& parameter : tool.parameters)
      values[parameter.name] = formats::checkParameter(parameter, parameter.default_value,
                                                       {stage.tool + " --describe", parameter.name, ""});
    overrideEach(tool, expanded(stage), {recipe_.file, "", at("stages", stage.name) + "/parameters"}, values);
    if (asset_.stages.contains(stage.name))
      overrideEach(tool, asset_.stages[stage.name], {asset_.file, "", at("stages", stage.name)}, values);
    for (const Setting& setting : options_.settings)
      if (setting.stage == stage.name) problems_.attempt([&] { applySetting(tool, setting, values); });
    return values;
  }

  Json expanded(const RecipeStage& stage) const {
    Json parameters = stage.parameters;
    for (auto& [name, value] : parameters.items())
      if (value.is_string())
        value = expand(value.get<std::string>(), asset_.name, placeOf(stage, "parameters", name));
    return parameters;
  }

  // One by one, so that each wrong one is reported.
  void overrideEach(const ToolDescription& tool, const Json& given, const ErrorPlace& place, Json& values) {
    if (!given.is_object()) formats::checkParameters(tool, given, place);
    for (const auto& [name, value] : given.items())
      problems_.attempt([&, name = name, value = value] {
        values.update(formats::checkParameters(tool, {{name, value}}, place));
      });
  }

  static void applySetting(const ToolDescription& tool, const Setting& setting, Json& values) {
    const auto* parameter = tool.findParameter(setting.parameter);
    const bool is_text = parameter != nullptr && parameter->type == formats::ParameterType::kText;
    Json value = is_text ? Json(setting.value) : Json::parse(setting.value, nullptr, false);
    if (value.is_discarded()) value = setting.value;
    try {
      values.update(formats::checkParameters(tool, {{setting.parameter, value}}, {setting.option, "", ""}));
    } catch (const Error& error) {
      // The same words as for a file, but it is the command line that is wrong.
      throw Error(ExitStatus::kUsage, {setting.option, "", ""}, error.problem(), error.expected(),
                  error.remedy());
    }
  }

  Graph& graph_;
  const std::size_t asset_index_;
  const Asset& asset_;
  const Recipe& recipe_;
  Toolbox& tools_;
  const GraphOptions& options_;
  Problems& problems_;
  std::set<std::string> delivered_, needed_;
  std::map<std::string, TaskIndex> task_of_;
};

// Deliverables, the folders of the stages and the record share one folder.
void checkOutputNames(const Graph& graph, Problems& problems) {
  std::vector<std::set<std::string>> taken(graph.assets.size(), {"record.json"});
  for (const Task& task : graph.tasks) taken[task.asset].insert(task.stage);
  for (const Task& task : graph.tasks) {
    std::set<std::string> own = {"stats.json", "parameters.json", "entry.json"};
    for (const auto& [port, file] : task.outputs) {
      const bool delivered = task.deliverables.count(port) != 0;
      const bool is_new = own.insert(file).second;
      if (!is_new || (delivered && !taken[task.asset].insert(file).second))
        problems.add(badInput({graph.assets[task.asset].file, "", ""},
                              "the output \"" + file + "\" of the stage " + task.stage +
                                  " would overwrite something else of that name",
                              "another output name in the recipe"));
    }
  }
}

void checkSettings(const Graph& graph, const std::vector<Setting>& settings, Problems& problems) {
  std::set<std::string> stages;
  for (const Task& task : graph.tasks) stages.insert(task.stage);
  if (graph.tasks.empty()) return;
  const std::vector<std::string> names(stages.begin(), stages.end());
  for (const Setting& setting : settings)
    if (stages.count(setting.stage) == 0)
      problems.add(Error(ExitStatus::kUsage, {setting.option, "", ""},
                         "there is no stage \"" + setting.stage + "\"", "one of: " + join(names, ", "),
                         suggestion(setting.stage, names)));
}

}  // namespace

std::string Graph::nameOf(TaskIndex task) const {
  return assets[tasks[task].asset].name + " " + tasks[task].stage;
}

Setting parseSetting(const std::string& text) {
  const std::size_t equals = text.find('='), dot = text.substr(0, equals).find('.');
  const std::string option = "--set " + text;
  if (equals == std::string::npos || dot == std::string::npos || dot == 0 || dot + 1 == equals)
    throw Error(ExitStatus::kUsage, {option, "", ""}, "is no setting", "--set stage.parameter=value",
                "--set transfer.order=5, for example");
  return {text.substr(0, dot), text.substr(dot + 1, equals - dot - 1), text.substr(equals + 1), option};
}

Graph makeGraph(std::vector<Asset> assets, RecipeBook& recipes, Toolbox& tools, const GraphOptions& options,
                Problems& problems) {
  Graph graph{.assets = std::move(assets)};
  for (std::size_t i = 0; i < graph.assets.size(); ++i)
    problems.attempt([&] {
      const Recipe& recipe = recipes.require(graph.assets[i].recipe, {graph.assets[i].file, "", "/recipe"});
      AssetStages(graph, i, recipe, tools, options, problems).add();
    });
  checkOutputNames(graph, problems);
  checkSettings(graph, options.settings, problems);
  return graph;
}

}  // namespace bakelight::pipeline
