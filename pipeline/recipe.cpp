#include "pipeline/recipe.h"

#include <algorithm>
#include <set>
#include <utility>

#include "formats/error.h"
#include "pipeline/json_object.h"
#include "pipeline/problems.h"

namespace bakelight::pipeline {
using formats::Json;
namespace {

constexpr const char* kWireSyntax = "\"stage.output\" or \"asset.file\", for example \"simplify.mesh\"";

template <class Map>
std::vector<std::string> keysOf(const Map& map) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : map) keys.push_back(key);
  return keys;
}

Wire parseWire(const JsonObject& object, const std::string& key) {
  const std::string text = object.text(key);
  const std::size_t dot = text.find('.');
  if (dot == std::string::npos || dot == 0 || dot + 1 == text.size())
    throw badInput(object.placeOf(key), "\"" + text + "\" is no wire", kWireSyntax);
  return {text.substr(0, dot), text.substr(dot + 1)};
}

AssetPort parseAssetPort(const JsonObject& object, Problems& problems) {
  object.allowKeys({"kind", "required", "endings"}, problems);
  return {object.text("kind"), object.boolean("required", true), object.texts("endings")};
}

RecipeStage parseStage(const std::string& name, const JsonObject& object, Problems& problems) {
  object.allowKeys({"tool", "inputs", "outputs", "parameters"}, problems);
  RecipeStage stage{.name = name, .tool = object.text("tool", name)};
  const JsonObject inputs = object.object("inputs"), outputs = object.object("outputs");
  for (const std::string& port : inputs.keys())
    problems.attempt([&] { stage.inputs[port] = parseWire(inputs, port); });
  for (const std::string& port : outputs.keys())
    problems.attempt([&] {
      stage.outputs[port] = outputs.text(port);
      if (stage.outputs[port].empty() || stage.outputs[port].find('/') != std::string::npos)
        throw badInput(outputs.placeOf(port), "\"" + stage.outputs[port] + "\" is no file name",
                       "a file name without a folder");
    });
  object.object("parameters");  // must be an object if it is there
  if (object.has("parameters")) stage.parameters = object.value("parameters");
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
    throw badInput(place, "there is no \"" + wire.text() + "\"", "one of: " + join(candidates, ", "),
                   suggestion(wire.text(), candidates));
}

void checkWires(const Recipe& recipe, Problems& problems) {
  for (const auto& [name, stage] : recipe.stages)
    for (const auto& [port, wire] : stage.inputs) {
      const ErrorPlace place{recipe.file, "", "/stages/" + name + "/inputs/" + port};
      problems.attempt([&, wire = wire] { checkWire(recipe, wire, place, true); });
    }
  for (const auto& [name, wire] : recipe.deliverables)
    problems.attempt([&, name = name, wire = wire] {
      checkWire(recipe, wire, {recipe.file, "", "/deliver/" + name}, false);
    });
}

}  // namespace

std::vector<std::string> Recipe::stageNames() const {
  return keysOf(stages);
}
std::vector<std::string> Recipe::deliverableNames() const {
  return keysOf(deliverables);
}

Recipe parseRecipe(const Json& json, const std::string& name, const std::string& file) {
  Problems problems;
  const JsonObject root(json, file);
  root.allowKeys({"summary", "asset", "stages", "deliver"}, problems);

  Recipe recipe{.name = name, .summary = root.text("summary", ""), .file = file};
  const JsonObject ports = root.object("asset"), stages = root.object("stages"),
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
      const auto& inputs = recipe.stages.at(name).inputs;
      return std::all_of(inputs.begin(), inputs.end(), [&](const auto& input) {
        return input.second.fromAsset() || placed.count(input.second.stage) != 0;
      });
    });
    if (ready == left.end())
      throw badInput({recipe.file, "", "/stages"},
                     "the stages " + join({left.begin(), left.end()}, ", ") + " wait for each other",
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
  const std::filesystem::path path = folder_ / (name + ".json");
  if (!disk_.isFile(path))
    throw badInput(place, "there is no recipe \"" + name + "\" in " + folder_.string(),
                   "one of: " + join(names(), ", "), suggestion(name, names()));
  const Json json = formats::parseJson(disk_.read(path), path.string());
  return read_.emplace(name, parseRecipe(json, name, path.string())).first->second;
}

std::vector<std::string> RecipeBook::names() const {
  std::vector<std::string> names;
  if (!disk_.isFolder(folder_)) return names;
  for (const std::string& file : disk_.list(folder_))
    if (file.ends_with(".json")) names.push_back(file.substr(0, file.size() - 5));
  return names;
}

}  // namespace bakelight::pipeline
