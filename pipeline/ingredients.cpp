#include "pipeline/ingredients.h"

#include "formats/hash.h"

namespace bakelight::pipeline {
using formats::Json;
namespace {

// Raised when entries of older versions could be wrong for the same ingredients.
constexpr int kCacheFormat = 1;

std::string dump(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void compareParameters(const Json& before, const Json& now, std::vector<std::string>& phrases) {
  for (const auto& [name, value] : now.items()) {
    if (!before.contains(name))
      phrases.push_back(name + " is new, with the value " + dump(value));
    else if (before[name] != value)
      phrases.push_back(name + " changed from " + dump(before[name]) + " to " + dump(value));
  }
  for (const auto& [name, value] : before.items())
    if (!now.contains(name)) phrases.push_back(name + " is no longer a parameter");
}

}  // namespace

std::string Ingredients::key() const {
  Json json = toJson(*this);
  json["cache_format"] = kCacheFormat;
  return formats::contentHash(dump(json));
}

Json toJson(const Ingredients& ingredients) {
  Json inputs = Json::object();
  for (const auto& [port, file] : ingredients.inputs)
    inputs[port] = {{"hash", file.hash}, {"ending", file.ending}};
  return {{"tool", ingredients.tool},
          {"tool_hash", ingredients.tool_hash},
          {"execution_path", ingredients.execution_path},
          {"parameters", ingredients.parameters},
          {"inputs", std::move(inputs)},
          {"outputs", ingredients.outputs}};
}

std::optional<Ingredients> ingredientsFromJson(const Json& json) {
  try {
    Ingredients ingredients{.tool = json.at("tool"),
                            .tool_hash = json.at("tool_hash"),
                            .execution_path = json.at("execution_path"),
                            .parameters = json.at("parameters"),
                            .inputs = {},
                            .outputs = json.at("outputs")};
    for (const auto& [port, file] : json.at("inputs").items())
      ingredients.inputs[port] = {file.at("hash"), file.at("ending")};
    return ingredients;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

std::vector<std::string> differences(const Ingredients& before, const Ingredients& now,
                                     const std::map<std::string, std::string>& origin_of) {
  std::vector<std::string> phrases;
  if (before.tool != now.tool) phrases.push_back("the tool changed from " + before.tool + " to " + now.tool);
  if (before.tool == now.tool && before.tool_hash != now.tool_hash)
    phrases.push_back("tool " + now.tool + " was rebuilt");
  if (before.execution_path != now.execution_path)
    phrases.push_back("the execution path changed from \"" + before.execution_path + "\" to \"" +
                      now.execution_path + "\"");
  compareParameters(before.parameters, now.parameters, phrases);
  for (const auto& [port, file] : now.inputs) {
    const auto old = before.inputs.find(port);
    if (old == before.inputs.end())
      phrases.push_back("input " + port + " is new (" + origin_of.at(port) + ")");
    else if (old->second != file)
      phrases.push_back("input " + port + " changed (" + origin_of.at(port) + ")");
  }
  for (const auto& [port, file] : before.inputs)
    if (now.inputs.count(port) == 0) phrases.push_back("input " + port + " is no longer given");
  if (before.outputs != now.outputs) phrases.push_back("the output names changed");
  return phrases;
}

}  // namespace bakelight::pipeline
