#include "pipeline/graph.h"

#include <algorithm>
#include <set>
#include <utility>

#include "formats/error.h"
#include "formats/words.h"

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
                          "one of: " + formats::join(all, ", "), formats::suggestion(asked[i], all)));
    }
  }

  // What is delivered, and what that is made from.
  void markNeeded() {
    for (const std::string& name : delivered_) markNeeded(recipe_.deliverables.at(name).stage);
    for (const std::string& stage : asset_.wanted) markNeeded(stage);
  }

  // With the stages whose figures are asked for by rules that may change something.
  void markNeeded(const std::string& name) {
    if (!needed_.insert(name).second) return;
    const RecipeStage& stage = recipe_.stages.at(name);
    for (const auto& [port, wire] : stage.inputs)
      if (!wire.fromAsset()) markNeeded(wire.stage);
    for (const auto& [parameter, figure] : measuredOf(stage)) markNeeded(figure.stage);
    const bool keep = options_.keep_all || asset_.keep_all || asset_.kept.count(name) != 0;
    for (const LeaveOutRule& rule : stage.leave_out)
      problems_.attempt([&] {
        if (keep && !rule.always) return;
        if (!rule.omit && !mayApply(rule, parametersOf(stage))) return;
        rules_[name].push_back(rule);
        markNeeded(rule.figure.stage);
        markNeeded(rule.error.stage);
      });
  }

  // What asset and settings say of a parameter goes before a figure.
  std::map<std::string, Wire> measuredOf(const RecipeStage& stage) const {
    std::map<std::string, Wire> measured = stage.measured;
    if (asset_.stages.contains(stage.name))
      for (const auto& [parameter, value] : asset_.stages[stage.name].items()) measured.erase(parameter);
    for (const std::vector<Setting>& settings : {options_.settings, asset_.settings})
      for (const Setting& setting : settings)
        if (setting.stage == stage.name) measured.erase(setting.parameter);
    return measured;
  }

  static bool mayApply(const LeaveOutRule& rule, const Json& parameters) {
    return std::any_of(rule.set.begin(), rule.set.end(), [&](const auto& change) {
      const auto value = parameters.find(change.first);
      return value != parameters.end() && rule.changed(change.first, *value).has_value();
    });
  }

  void checkOverriddenStages() {
    const std::vector<std::string> stages = recipe_.stageNames();
    for (const auto& [stage, ignored] : asset_.stages.items())
      if (recipe_.stages.count(stage) == 0)
        problems_.add(badInput({asset_.file, "", at("stages", stage)},
                               "the recipe " + recipe_.name + " has no stage \"" + stage + "\"",
                               "one of: " + formats::join(stages, ", "), formats::suggestion(stage, stages)));
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
      task.parameters = parametersOf(stage);
      checkRules(stage, tool);
      for (const LeaveOutRule& rule : rules_[stage.name])
        if (const auto figure = makerOf(rule.figure), error = makerOf(rule.error); figure && error)
          task.rules.push_back({rule, *figure, *error});
      for (const auto& [parameter, figure] : measuredOf(stage)) {
        if (!task.parameters.contains(parameter))
          problems_.add(badInput(placeOf(stage, "parameters", parameter),
                                 "the tool " + tool.tool + " has no parameter \"" + parameter + "\"",
                                 "a parameter of the tool"));
        else if (const auto maker = makerOf(figure))
          task.measured.push_back({parameter, figure, *maker});
      }
    }
    task_of_[stage.name] = graph_.tasks.size();
    graph_.tasks.push_back(std::move(task));
  }

  const std::string& label() const { return asset_.label.empty() ? asset_.name : asset_.label; }

  void wire(const RecipeStage& stage, Task& task) {
    for (const auto& [port, wire] : stage.inputs) {
      if (!wire.fromAsset())
        task.inputs[port] = {.maker = makerOf(wire), .port = wire.port};
      else if (const auto input = inputFrom(asset_, wire.port, partsOf(stage.tool, port)))
        task.inputs[port] = *input;
    }
    for (const auto& [port, file] : stage.outputs)
      task.outputs[port] = expand(file, label(), placeOf(stage, "outputs", port));
    for (const std::string& name : delivered_)
      if (recipe_.deliverables.at(name).stage == stage.name)
        task.deliverables[recipe_.deliverables.at(name).port] = name;
  }

  std::vector<std::string> partsOf(const std::string& tool, const std::string& port) {
    if (!tools_.has(tool)) return {};
    const auto* input = tools_.require(tool, {}).description.findInput(port);
    return input == nullptr ? std::vector<std::string>() : input->parts;
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
      else if (wired->second.fromAsset() && !asset_.supplies(wired->second.port))
        problems_.add(badInput(
            {asset_.file, "", ""},
            "the stage " + stage.name + " needs the asset's " + wired->second.port + ", and there is none",
            "\"" + wired->second.port + "\" in asset.json"));
      else if (!wired->second.fromAsset() && mayLack(stage.name, wired->second.stage))
        problems_.add(
            badInput(placeOf(stage, "inputs", input.name),
                     "the stage " + wired->second.stage + " may be left out by a rule, and the tool " +
                         tool.tool + " requires this input",
                     "an input that the tool can do without",
                     "give the stage " + stage.name + " the same rule, so that it is left out, too"));
    }
    for (const auto& output : tool.outputs)
      if (output.required && stage.outputs.count(output.name) == 0)
        problems_.add(badInput(placeOf(stage, "outputs", output.name), "the output has no file name",
                               "a file name, as the tool " + tool.tool + " always writes it"));
  }

  // Whether a rule may omit `maker` where none omits `user`.
  bool mayLack(const std::string& user, const std::string& maker) {
    const std::vector<LeaveOutRule>& own = rules_[user];
    return std::any_of(rules_[maker].begin(), rules_[maker].end(), [&](const LeaveOutRule& rule) {
      return rule.omit && std::none_of(own.begin(), own.end(), [&](const LeaveOutRule& other) {
               return other.omit && other.figure.text() == rule.figure.text() &&
                      other.at_most >= rule.at_most;
             });
    });
  }

  void checkPort(const ToolDescription& tool, const std::vector<formats::PortDescription>& ports,
                 const std::string& name, const std::string& kind, const char* direction,
                 const ErrorPlace& place) {
    std::vector<std::string> names;
    for (const auto& port : ports) {
      names.push_back(port.name);
      if (port.name != name) continue;
      if (!kind.empty() && kind != port.kind && port.kind != formats::kAnyKind)
        problems_.add(badInput(
            place, "a file of kind \"" + kind + "\" is wired to an input of kind \"" + port.kind + "\"",
            "files of one kind"));
      return;
    }
    problems_.add(badInput(place, "the tool " + tool.tool + " has no " + direction + " \"" + name + "\"",
                           "one of: " + formats::join(names, ", "), formats::suggestion(name, names)));
  }

  // "" if not known (its maker is left out and not installed).
  std::string kindOf(const Wire& wire) {
    if (wire.fromAsset()) return recipe_.asset.at(wire.port).kind;
    const std::string& tool = recipe_.stages.at(wire.stage).tool;
    if (!tools_.has(tool)) return "";
    const auto* port = tools_.require(tool, {}).description.findOutput(wire.port);
    return port == nullptr ? "" : port->kind;
  }

  // That what the recipe's rules set are values of the tool.
  void checkRules(const RecipeStage& stage, const ToolDescription& tool) {
    for (std::size_t i = 0; i < stage.leave_out.size(); ++i)
      for (const auto& [parameter, values] : stage.leave_out[i].set)
        for (const auto& [from, to] : values)
          problems_.attempt([&, parameter = parameter, to = to] {
            formats::checkParameters(
                tool, {{parameter, to}},
                {recipe_.file, "", at("stages", stage.name) + "/leave_out/" + std::to_string(i) + "/set"});
          });
  }

  // Judged once a stage, so that a mistake is reported once.
  const Json& parametersOf(const RecipeStage& stage) {
    const auto known = parameters_.find(stage.name);
    if (known != parameters_.end()) return known->second;
    parameters_[stage.name] = Json::object();  // ends a circle of links
    const ErrorPlace place{recipe_.file, "", at("stages", stage.name) + "/tool"};
    return parameters_[stage.name] = judgedParameters(stage, tools_.require(stage.tool, place).description);
  }

  Json linkedParameters(const RecipeStage& stage) {
    Json values = Json::object();
    for (const auto& [name, link] : stage.linked) {
      const Json& others = parametersOf(recipe_.stages.at(link.stage));
      const ErrorPlace place{recipe_.file, "", at("stages", stage.name) + "/parameters/" + name + "/same_as"};
      if (!others.contains(link.port))
        throw badInput(place, "the stage " + link.stage + " has no parameter \"" + link.port + "\"",
                       "a parameter of its tool, and no circle of links");
      values[name] = others[link.port];
    }
    return values;
  }

  Json judgedParameters(const RecipeStage& stage, const ToolDescription& tool) {
    Json values = defaultParameters(tool);
    const ErrorPlace place{recipe_.file, "", at("stages", stage.name) + "/parameters"};
    overrideEach(tool, expanded(stage), place, values);
    problems_.attempt([&] { overrideEach(tool, linkedParameters(stage), place, values); });
    if (asset_.stages.contains(stage.name))
      overrideEach(tool, asset_.stages[stage.name], {asset_.file, "", at("stages", stage.name)}, values);
    for (const std::vector<Setting>& settings : {options_.settings, asset_.settings})
      for (const Setting& setting : settings)
        if (setting.stage == stage.name) problems_.attempt([&] { applySetting(tool, setting, values); });
    return values;
  }

  Json expanded(const RecipeStage& stage) const {
    Json parameters = stage.parameters;
    for (auto& [name, value] : parameters.items())
      if (value.is_string())
        value = expand(value.get<std::string>(), label(), placeOf(stage, "parameters", name));
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

  void applySetting(const ToolDescription& tool, const Setting& setting, Json& values) {
    const auto* parameter = tool.findParameter(setting.parameter);
    const bool is_text = parameter != nullptr && parameter->type == formats::ParameterType::kText;
    Json value = is_text ? Json(setting.value) : Json::parse(setting.value, nullptr, false);
    if (value.is_discarded()) value = setting.value;
    try {
      values.update(formats::checkParameters(tool, {{setting.parameter, value}}, {setting.option, "", ""}));
    } catch (const Error& error) {
      // The same words as for a file, but it is the command line that is wrong.
      const std::string elsewhere = parameter == nullptr ? stageWith(setting.parameter) : "";
      throw Error(ExitStatus::kUsage, {setting.option, "", ""}, error.problem(), error.expected(),
                  elsewhere.empty() ? error.remedy() : "write " + elsewhere + "." + setting.parameter);
    }
  }

  // The first stage whose tool has a parameter of that name, "" if none has.
  std::string stageWith(const std::string& parameter) {
    for (const auto& [name, stage] : recipe_.stages)
      if (tools_.has(stage.tool) &&
          tools_.require(stage.tool, {}).description.findParameter(parameter) != nullptr)
        return name;
    return "";
  }

  Graph& graph_;
  const std::size_t asset_index_;
  const Asset& asset_;
  const Recipe& recipe_;
  Toolbox& tools_;
  const GraphOptions& options_;
  Problems& problems_;
  std::set<std::string> delivered_, needed_;
  std::map<std::string, std::vector<LeaveOutRule>> rules_;  // by stage; those that may apply
  std::map<std::string, Json> parameters_;                  // by stage, once judged
  std::map<std::string, TaskIndex> task_of_;
};

// Deliverables, the folders of the stages and the record share one folder.
void checkOutputNames(const Graph& graph, Problems& problems) {
  std::vector<std::set<std::string>> taken(graph.assets.size(), {"record.json"});
  for (const Task& task : graph.tasks) taken[task.asset].insert(task.stage);
  for (const Task& task : graph.tasks) {
    std::set<std::string> own = {"stats.json", "parameters.json", "entry.json"};
    for (const auto& [port, input] : task.inputs)
      if (!input.value.is_null()) own.insert(port + ".json");
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
                         "there is no stage \"" + setting.stage + "\"",
                         "one of: " + formats::join(names, ", "), formats::suggestion(setting.stage, names)));
}

}  // namespace

std::string Graph::nameOf(TaskIndex task) const {
  return assets[tasks[task].asset].name + " " + tasks[task].stage;
}

std::set<TaskIndex> Graph::makersOf(TaskIndex task) const {
  std::set<TaskIndex> makers;
  for (const auto& [port, input] : tasks[task].inputs)
    if (input.maker) makers.insert(*input.maker);
  for (const TaskRule& rule : tasks[task].rules) {
    makers.insert(rule.figure_maker);
    makers.insert(rule.error_maker);
  }
  for (const MeasuredParameter& parameter : tasks[task].measured) makers.insert(parameter.maker);
  return makers;
}

std::set<TaskIndex> Graph::judgesOf(TaskIndex task) const {
  std::set<TaskIndex> makers;
  for (const TaskRule& rule : tasks[task].rules)
    if (rule.rule.omit) makers.merge(std::set<TaskIndex>{rule.figure_maker, rule.error_maker});
  return makers;
}

std::optional<Input> inputFrom(const Asset& asset, const std::string& port,
                               const std::vector<std::string>& parts) {
  Input input{.maker = std::nullopt, .port = port};
  if (const auto file = asset.files.find(port); file != asset.files.end()) {
    input.file = file->second;
    return input;
  }
  const auto materials = asset.materials.find(port);
  if (materials == asset.materials.end()) return std::nullopt;
  input.file = asset.file;
  input.value = formats::toJson(materials->second, parts);
  return input;
}

Json defaultParameters(const ToolDescription& tool) {
  Json values = Json::object();
  for (const auto& parameter : tool.parameters)
    values[parameter.name] = formats::checkParameter(parameter, parameter.default_value,
                                                     {tool.tool + " --describe", parameter.name, ""});
  return values;
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
  for (const Asset& asset : graph.assets) checkSettings(graph, asset.settings, problems);
  return graph;
}

}  // namespace bakelight::pipeline
