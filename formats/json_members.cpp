#include "formats/json_members.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "formats/tool_description.h"

namespace bakelight::formats {
namespace {

ParameterDescription rule(const std::string& name, ParameterType type) {
  ParameterDescription description;
  description.name = name;
  description.type = type;
  return description;
}

ParameterDescription rule(const std::string& name, ParameterType type, JsonMembers::Range range) {
  ParameterDescription description = rule(name, type);
  description.minimum = range.minimum;
  description.maximum = range.maximum;
  return description;
}

}  // namespace

JsonMembers::JsonMembers(const Json& object, std::string file, std::string pointer)
    : object_(object), file_(std::move(file)), pointer_(std::move(pointer)) {
  if (!object.is_object())
    throw badInput({file_, "", pointer_}, std::string("is ") + object.type_name(), "a JSON object { ... }");
}

ErrorPlace JsonMembers::placeOf(const std::string& name) const {
  return {file_, "", childPointer(pointer_, name)};
}

std::vector<std::string> JsonMembers::names() const {
  std::vector<std::string> names;
  for (const auto& [name, ignored] : object_.items()) names.push_back(name);
  return names;
}

const Json* JsonMembers::find(const std::string& name) {
  if (std::find(known_.begin(), known_.end(), name) == known_.end()) known_.push_back(name);
  const auto found = object_.find(name);
  return found == object_.end() ? nullptr : &*found;
}

const Json& JsonMembers::require(const std::string& name, const std::string& expected) {
  const Json* found = find(name);
  if (found == nullptr)
    throw badInput({file_, "", pointer_}, "the key \"" + name + "\" is missing", expected);
  return *found;
}

void JsonMembers::read(const std::string& name, double& value, Range range) {
  if (const Json* json = find(name)) value = real(*json, name, range, placeOf(name));
}

void JsonMembers::read(const std::string& name, bool& value) {
  if (const Json* json = find(name))
    value = checkParameter(rule(name, ParameterType::kBoolean), *json, placeOf(name));
}

void JsonMembers::read(const std::string& name, Float3& value, Range range) {
  if (const Json* json = find(name)) value = triple(*json, name, range, placeOf(name));
}

void JsonMembers::read(const std::string& name, std::string& value) {
  if (const Json* json = find(name))
    value = checkParameter(rule(name, ParameterType::kText), *json, placeOf(name)).get<std::string>();
}

std::size_t JsonMembers::readChoice(const std::string& name, const std::vector<std::string>& choices) {
  ParameterDescription choice = rule(name, ParameterType::kText);
  choice.choices = choices;
  const Json& json = require(name, expectation(choice));
  const auto word = checkParameter(choice, json, placeOf(name)).get<std::string>();
  return static_cast<std::size_t>(std::find(choices.begin(), choices.end(), word) - choices.begin());
}

std::filesystem::path JsonMembers::readFile(const std::string& name, const std::string& expected,
                                            const std::string& remedy) {
  const Json text = checkParameter(rule(name, ParameterType::kText), require(name, expected), placeOf(name));
  const std::filesystem::path path =
      (std::filesystem::path(file_).parent_path() / text.get<std::string>()).lexically_normal();
  if (!std::filesystem::is_regular_file(path))
    throw badInput(placeOf(name), "there is no file " + path.string(), expected, remedy);
  return path;
}

Float3 JsonMembers::triple(const Json& json, const std::string& name, Range range, const ErrorPlace& place) {
  ParameterDescription numbers_rule = rule(name, ParameterType::kRealList, range);
  numbers_rule.length = 3;
  const Json numbers = checkParameter(numbers_rule, json, place);
  return {numbers[0].get<float>(), numbers[1].get<float>(), numbers[2].get<float>()};
}

double JsonMembers::real(const Json& json, const std::string& name, Range range, const ErrorPlace& place) {
  return checkParameter(rule(name, ParameterType::kReal, range), json, place).get<double>();
}

void JsonMembers::refuseOthers() const {
  for (const auto& [name, ignored] : object_.items()) {
    if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
    std::string list;
    for (const std::string& known : known_) list += (list.empty() ? "" : ", ") + known;
    const std::string nearest = nearestName(name, known_);
    throw badInput(placeOf(name), "unknown key \"" + name + "\"", "one of: " + list,
                   nearest.empty() ? "" : "write \"" + nearest + "\"");
  }
}

}  // namespace bakelight::formats
