#include "pipeline/json_object.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

namespace bakelight::pipeline {
using formats::Json;

std::string join(const std::vector<std::string>& words, const std::string& separator) {
  std::string text;
  for (const std::string& word : words) {
    if (!text.empty()) text += separator;
    text += word;
  }
  return text;
}

std::string suggestion(std::string_view name, const std::vector<std::string>& candidates) {
  const std::string nearest = formats::nearestName(name, candidates);
  return nearest.empty() ? "" : "write \"" + nearest + "\"";
}

JsonObject::JsonObject(const Json& value, std::string file, std::string pointer)
    : value_(&value), file_(std::move(file)), pointer_(std::move(pointer)) {
  if (!value.is_object())
    throw badInput({file_, "", pointer_}, std::string("is ") + value.type_name(), "a JSON object { ... }");
}

void JsonObject::allowKeys(const std::vector<std::string>& allowed, Problems& problems) const {
  for (const std::string& key : keys())
    if (std::find(allowed.begin(), allowed.end(), key) == allowed.end())
      problems.add(badInput(placeOf(key), "unknown key \"" + key + "\"", "one of: " + join(allowed, ", "),
                            suggestion(key, allowed)));
}

bool JsonObject::has(std::string_view key) const {
  return value_->contains(key);
}

std::vector<std::string> JsonObject::keys() const {
  std::vector<std::string> names;
  for (const auto& [key, ignored] : value_->items()) names.push_back(key);
  return names;
}

ErrorPlace JsonObject::placeOf(std::string_view key) const {
  return {file_, "", formats::childPointer(pointer_, key)};
}

const Json& JsonObject::value(std::string_view key) const {
  return value_->at(std::string(key));
}

const Json& JsonObject::require(std::string_view key, const char* expected) const {
  if (!has(key))
    throw badInput({file_, "", pointer_}, "the key \"" + std::string(key) + "\" is missing", expected);
  return value(key);
}

std::string JsonObject::text(std::string_view key) const {
  const Json& found = require(key, "a text");
  if (!found.is_string()) throw badInput(placeOf(key), found.dump() + " is not a text", "a text in quotes");
  return found.get<std::string>();
}

std::string JsonObject::text(std::string_view key, const std::string& default_value) const {
  return has(key) ? text(key) : default_value;
}

bool JsonObject::boolean(std::string_view key, bool default_value) const {
  if (!has(key)) return default_value;
  if (!value(key).is_boolean())
    throw badInput(placeOf(key), value(key).dump() + " is not a truth value", "true or false");
  return value(key).get<bool>();
}

std::vector<std::string> JsonObject::texts(std::string_view key) const {
  if (!has(key)) return {};
  const Json& list = value(key);
  const auto is_text = [](const Json& element) { return element.is_string(); };
  if (!list.is_array() || !std::all_of(list.begin(), list.end(), is_text))
    throw badInput(placeOf(key), list.dump() + " is not a list of texts", "a list of texts, [\"...\"]");
  return list.get<std::vector<std::string>>();
}

JsonObject JsonObject::object(std::string_view key) const {
  static const Json kEmpty = Json::object();
  return {has(key) ? value(key) : kEmpty, file_, placeOf(key).pointer};
}

}  // namespace bakelight::pipeline
