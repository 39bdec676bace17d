#include "pipeline/recipe.h"

#include <algorithm>
#include <set>
#include <utility>

#include "formats/error.h"
#include "formats/json_reader.h"
#include "formats/words.h"
#include "pipeline/problems.h"

namespace bakelight::pipeline {
using formats::Json;
using formats::JsonReader;
namespace {

constexpr const char* kWireSyntax = "\"stage.output\" or \"asset.file\", for example \"simplify.mesh\"";

template <class Map>
std::vector<std::string> keysOf(const Map& map) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : map) keys.push_back(key);
  return keys;
}

Wire parseWire(const JsonReader& object, const std::string& key) {
  const std::string& text = object.text(key);
  const std::size_t dot = text.find('.');
  if (dot == std::string::npos || dot == 0 || dot + 1 == text.size())
    throw badInput(object.placeOf(key), "\"" + text + "\" is no wire", kWireSyntax);
  return {text.substr(0, dot), text.substr(dot + 1)};
}

AssetPort parseAssetPort(const JsonReader& object, Problems& problems) {
  problems.add(object.unknownKeys({"kind", "required", "endings", "default"}));
  AssetPort port{object.text("kind"), object.boolean("required", true), object.texts("endings")};
  if (!object.has("default")) return port;
  object.object("default");
  port.otherwise = object.value("default");
  return port;
}

LeaveOutRule parseRule(const JsonReader& object, Problems& problems) {
  problems.add(object.unknownKeys({"what", "figure", "at_most", "error", "set", "omit", "always"}));
  LeaveOutRule rule{.what = object.text("what"), .figure = parseWire(object, "figure")};
  rule.error = object.has("error") ? parseWire(object, "error") : rule.figure;
  rule.at_most = object.number("at_most");
  const JsonReader set = object.object("set");
  for (const std::string& parameter : set.keys()) {
    const JsonReader values = set.object(parameter);
    for (const std::string& value : values.keys()) rule.set[parameter][value] = values.value(value);
  }
  rule.omit = object.boolean("omit", false);
  rule.always = object.boolean("always", false);
  if (rule.omit && !rule.set.empty())
    throw badInput(object.placeOf("set"), "a stage that is left out as a whole has nothing to set",
                   "\"set\" or \"omit\", not both");
  if (!rule.omit && rule.set.empty())
    throw badInput(object.placeOf("set"), "the rule changes nothing",
                   "{ parameter: { value: new value } }, or \"omit\": true for the whole stage");
  return rule;
}

}  // namespace

std::optional<Json> LeaveOutRule::changed(const std::string& parameter, const Json& current) const {
  const auto values = set.find(parameter);
  if (values == set.end()) return {};
  auto instead = values->second.find(current.is_string() ? current.get<std::string>() : current.dump());
  if (instead == values->second.end()) instead = values->second.find("*");
  if (instead == values->second.end() || instead->second == current) return {};
  return instead->second;
}

namespace {

void parseParameters(const JsonReader& object, RecipeStage& stage, Problems& problems) {
  const JsonReader parameters = object.object("parameters");  // must be an object if it is there
  for (const std::string& name : parameters.keys()) {
    if (!parameters.value(name).is_object()) {
      stage.parameters[name] = parameters.value(name);
      continue;
    }
    const JsonReader link = parameters.object(name);
    problems.add(link.unknownKeys({"same_as", "figure"}));
    problems.attempt([&] {
      if (link.has("figure"))
        stage.measured[name] = parseWire(link, "figure");
      else
        stage.linked[name] = parseWire(link, "same_as");
    });
  }
}

RecipeStage parseStage(const std::string& name, const JsonReader& object, Problems& problems) {
  problems.add(object.unknownKeys({"tool", "inputs", "outputs", "parameters", "leave_out"}));
  RecipeStage stage{.name = name, .tool = object.text("tool", name)};
  const JsonReader inputs = object.object("inputs"), outputs = object.object("outputs");
  for (const std::string& port : inputs.keys())
    problems.attempt([&] { stage.inputs[port] = parseWire(inputs, port); });
  for (const std::string& port : outputs.keys())
    problems.attempt([&] {
      stage.outputs[port] = outputs.text(port);
      if (stage.outputs[port].empty() || stage.outputs[port].find('/') != std::string::npos)
        throw badInput(outputs.placeOf(port), "\"" + stage.outputs[port] + "\" is no file name",
                       "a file name without a folder");
    });
  parseParameters(object, stage, problems);
  for (const JsonReader& rule : object.items("leave_out"))
    problems.attempt([&] { stage.leave_out.push_back(parseRule(rule, problems)); });
  return stage;
}

// That what `wire` names exists.
void checkWire(const Recipe& recipe, const Wire& wire, const ErrorPlace& place, bool asset_allowed) {
  std::vector<std::string> candidates;
  if (asset_allowed)
    for (const auto& [port, ignored] : recipe.asset) candidates.push_back(Wire{Wire::kAsset, port}.text());
  for (const auto& [name, stage] : recipe.stages)
    for (const auto& [port, file] : stage.outputs) candidates.push_back(Wire{name, port}.text());
  if (std::find(candidates.begin(), candidates.end(), wire.text()) == candidates.end())
    throw badInput(place, "there is no \"" + wire.text() + "\"", "one of: " + formats::join(candidates, ", "),
                   formats::suggestion(wire.text(), candidates));
}

// That the stage exists of which `name` names a parameter or a figure.
void checkStage(const Recipe& recipe, const Wire& name, const ErrorPlace& place) {
  if (recipe.stages.count(name.stage) == 0)
    throw badInput(place, "there is no stage \"" + name.stage + "\"",
                   "one of: " + formats::join(recipe.stageNames(), ", "),
                   formats::suggestion(name.stage, recipe.stageNames()));
}

// That `figure` is told whatever is left out.
void checkFigure(const Recipe& recipe, const Wire& figure, const ErrorPlace& place) {
  checkStage(recipe, figure, place);
  if (recipe.stages.at(figure.stage).mayBeOmitted())
    throw badInput(place,
                   "the stage " + figure.stage + " may be left out as a whole, and then tells no figure",
                   "a figure of a stage that no rule omits");
}

void checkWires(const Recipe& recipe, Problems& problems) {
  for (const auto& [name, stage] : recipe.stages)
    for (const auto& [port, wire] : stage.inputs) {
      const ErrorPlace place{recipe.file, "", "/stages/" + name + "/inputs/" + port};
      problems.attempt([&, wire = wire] { checkWire(recipe, wire, place, true); });
    }
  for (const auto& [name, stage] : recipe.stages) {
    const std::string pointer = "/stages/" + name;
    for (const auto& [parameter, link] : stage.linked)
      problems.attempt([&, parameter = parameter, link = link] {
        checkStage(recipe, link, {recipe.file, "", pointer + "/parameters/" + parameter + "/same_as"});
      });
    for (const auto& [parameter, figure] : stage.measured)
      problems.attempt([&, parameter = parameter, figure = figure] {
        checkFigure(recipe, figure, {recipe.file, "", pointer + "/parameters/" + parameter + "/figure"});
      });
    for (std::size_t i = 0; i < stage.leave_out.size(); ++i)
      for (const auto& [key, wire] :
           {std::pair("figure", stage.leave_out[i].figure), std::pair("error", stage.leave_out[i].error)})
        problems.attempt([&, key = key, wire = wire] {
          checkFigure(recipe, wire,
                      {recipe.file, "", pointer + "/leave_out/" + std::to_string(i) + "/" + key});
        });
  }
  for (const auto& [name, wire] : recipe.deliverables)
    problems.attempt([&, name = name, wire = wire] {
      checkWire(recipe, wire, {recipe.file, "", "/deliver/" + name}, false);
    });
}

// RFC 7396 with lists that grow: `own` over `base`; null takes a key away, "name+" appends to the list
// "name".
Json merged(Json base, const Json& own, const std::string& file, const std::string& pointer) {
  if (!own.is_object()) return own;
  if (!base.is_object()) base = Json::object();
  for (const auto& [key, value] : own.items()) {
    const std::string place = pointer + "/" + key;
    if (key.ends_with('+')) {
      const auto list = base.find(key.substr(0, key.size() - 1));
      if (list == base.end() || !list->is_array() || !value.is_array())
        throw badInput({file, "", place}, "it appends to no list", "a list, and one to append it to");
      list->insert(list->end(), value.begin(), value.end());
    } else if (value.is_null()) {
      base.erase(key);
    } else {
      base[key] = merged(base.contains(key) ? base[key] : Json(), value, file, place);
    }
  }
  return base;
}

}  // namespace

bool RecipeStage::mayBeOmitted() const {
  return std::any_of(leave_out.begin(), leave_out.end(), [](const LeaveOutRule& rule) { return rule.omit; });
}

std::set<std::string> RecipeStage::makers() const {
  std::set<std::string> makers;
  for (const auto& [port, wire] : inputs)
    if (!wire.fromAsset()) makers.insert(wire.stage);
  for (const LeaveOutRule& rule : leave_out) {
    makers.insert(rule.figure.stage);
    makers.insert(rule.error.stage);
  }
  for (const auto& [parameter, figure] : measured) makers.insert(figure.stage);
  return makers;
}

std::vector<std::string> Recipe::stageNames() const {
  return keysOf(stages);
}
std::vector<std::string> Recipe::deliverableNames() const {
  return keysOf(deliverables);
}

Recipe parseRecipe(const Json& json, const std::string& name, const std::string& file) {
  Problems problems;
  const JsonReader root(json, file);
  problems.add(root.unknownKeys({"summary", "asset", "stages", "deliver", "report"}));

  Recipe recipe{.name = name, .summary = root.text("summary", ""), .file = file};
  const JsonReader ports = root.object("asset"), stages = root.object("stages"),
                   deliver = root.object("deliver");
  for (const std::string& port : ports.keys())
    problems.attempt([&] { recipe.asset[port] = parseAssetPort(ports.object(port), problems); });
  for (const std::string& stage : stages.keys())
    problems.attempt([&] {
      if (stage == Wire::kAsset)
        throw badInput(stages.placeOf(stage), "\"asset\" stands for the asset's own files",
                       "another stage name");
      recipe.stages[stage] = parseStage(stage, stages.object(stage), problems);
    });
  root.object("report");
  if (root.has("report")) recipe.report = root.value("report");
  for (const std::string& deliverable : deliver.keys())
    problems.attempt([&] { recipe.deliverables[deliverable] = parseWire(deliver, deliverable); });

  problems.throwIfAny();
  checkWires(recipe, problems);
  problems.throwIfAny();
  stagesInOrder(recipe);
  return recipe;
}

std::vector<std::string> stagesInOrder(const Recipe& recipe) {
  std::vector<std::string> order;
  std::set<std::string> placed, left;
  for (const auto& [name, stage] : recipe.stages) left.insert(name);
  while (!left.empty()) {
    const auto ready = std::find_if(left.begin(), left.end(), [&](const std::string& name) {
      const std::set<std::string> makers = recipe.stages.at(name).makers();
      return std::includes(placed.begin(), placed.end(), makers.begin(), makers.end());
    });
    if (ready == left.end())
      throw badInput({recipe.file, "", "/stages"},
                     "the stages " + formats::join({left.begin(), left.end()}, ", ") + " wait for each other",
                     "wiring without a cycle");
    order.push_back(*ready);
    placed.insert(*ready);
    left.erase(ready);
  }
  return order;
}

std::string expand(const std::string& text, const std::string& asset, const ErrorPlace& place) {
  static const std::string kAssetName = "{asset}";
  std::string expanded;
  for (std::size_t i = 0; i < text.size();) {
    if (text.compare(i, kAssetName.size(), kAssetName) == 0) {
      expanded += asset;
      i += kAssetName.size();
    } else if (text[i] == '{') {
      throw badInput(place, "\"" + text + "\" has a placeholder that is not known", "{asset}");
    } else {
      expanded += text[i++];
    }
  }
  return expanded;
}

const Recipe& RecipeBook::require(const std::string& name, const ErrorPlace& place) {
  const auto known = read_.find(name);
  if (known != read_.end()) return known->second;
  return read_.emplace(name, parseRecipe(whole(name, place, {}), name, fileOf(name).string())).first->second;
}

std::filesystem::path RecipeBook::fileOf(const std::string& name) const {
  return folder_ / (name + ".json");
}

Json RecipeBook::whole(const std::string& name, const ErrorPlace& place,
                       std::vector<std::string> extending) const {
  const std::filesystem::path path = fileOf(name);
  if (!disk_.isFile(path))
    throw badInput(place, "there is no recipe \"" + name + "\" in " + folder_.string(),
                   "one of: " + formats::join(names(), ", "), formats::suggestion(name, names()));
  Json own = formats::parseJson(disk_.read(path), path.string());
  if (!own.is_object() || !own.contains("extends")) return own;
  const ErrorPlace extends{path.string(), "", "/extends"};
  if (!own["extends"].is_string())
    throw badInput(extends, "is no text", "the name of the recipe that it builds on");
  const auto base = own["extends"].get<std::string>();
  extending.push_back(name);
  if (std::find(extending.begin(), extending.end(), base) != extending.end())
    throw badInput(extends,
                   "recipes build on each other in a circle: " + formats::join(extending, ", ") + ", " + base,
                   "one that builds on none");
  own.erase("extends");
  return merged(whole(base, extends, std::move(extending)), own, path.string(), "");
}

std::vector<std::string> RecipeBook::names() const {
  std::vector<std::string> names;
  if (!disk_.isFolder(folder_)) return names;
  for (const std::string& file : disk_.list(folder_))
    if (file.ends_with(".json")) names.push_back(file.substr(0, file.size() - 5));
  return names;
}

}  // namespace bakelight::pipeline
