#include "tools/report/json_element.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace bakelight::report {

JsonElement::JsonElement(const formats::Json& value, std::string file, std::string pointer)
    : value_(&value), file_(std::move(file)), pointer_(std::move(pointer)) {}

Error JsonElement::error(const std::string& what, const std::string& expected) const {
  return badInput({file_, "", pointer_}, what, expected);
}

std::string JsonElement::text() const {
  if (!value_->is_string()) throw error("it is not a text", "a text");
  return value_->get<std::string>();
}

double JsonElement::number() const {
  if (!value_->is_number() || !std::isfinite(value_->get<double>()))
    throw error("it is not a number", "a finite number");
  return value_->get<double>();
}

double JsonElement::atLeastZero() const {
  const double value = number();
  if (value < 0) throw error("it is negative", "a number of 0 or more");
  return value;
}

std::vector<JsonElement> JsonElement::items() const {
  if (!value_->is_array()) throw error("it is not a list", "a list");
  std::vector<JsonElement> items;
  for (const formats::Json& item : *value_)
    items.emplace_back(item, file_, formats::childPointer(pointer_, std::to_string(items.size())));
  return items;
}

void JsonElement::requireKeys(const std::vector<std::string>& required,
                              const std::vector<std::string>& optional) const {
  if (!value_->is_object()) throw error("it is not an object", "an object");
  for (const std::string& key : required)
    if (!value_->contains(key)) throw error("the key \"" + key + "\" is missing", "it");
  std::vector<std::string> known = required;
  known.insert(known.end(), optional.begin(), optional.end());
  for (const auto& [key, unused] : value_->items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string nearest = formats::nearestName(key, known);
    throw badInput({file_, "", formats::childPointer(pointer_, key)}, "there is no such key",
                   nearest.empty() ? "" : "\"" + nearest + "\"");
  }
}

JsonElement JsonElement::at(const std::string& key) const {
  return {value_->at(key), file_, formats::childPointer(pointer_, key)};
}

std::optional<JsonElement> JsonElement::find(const std::string& key) const {
  const auto found = value_->find(key);
  if (found == value_->end() || found->is_null()) return std::nullopt;
  return at(key);
}

}  // namespace bakelight::report
