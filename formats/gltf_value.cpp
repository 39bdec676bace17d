#include "formats/gltf_value.h"

#include <nlohmann/json.hpp>
#include <utility>

namespace bakelight::formats {

GltfValue::GltfValue(const Json& json, std::string pointer, std::shared_ptr<const std::string> file)
    : json_(&json), pointer_(std::move(pointer)), file_(std::move(file)) {}

Error GltfValue::error(const std::string& what, const std::string& expected, const std::string& remedy,
                       const std::string& element) const {
  return badInput({*file_, element, pointer_}, what, expected,
                  remedy.empty() ? "export the file again" : remedy);
}

std::optional<GltfValue> GltfValue::find(std::string_view key) const {
  if (!json_->is_object()) throw error(std::string("it is a ") + json_->type_name(), "an object");
  const auto place = json_->find(key);
  if (place == json_->end()) return std::nullopt;
  return GltfValue(*place, childPointer(pointer_, key), file_);
}

GltfValue GltfValue::at(std::string_view key) const {
  if (auto value = find(key)) return *std::move(value);
  throw error("it has no \"" + std::string(key) + "\"");
}

std::optional<GltfValue> GltfValue::extension(std::string_view name) const {
  const auto extensions = find("extensions");
  return extensions ? extensions->find(name) : std::nullopt;
}

std::vector<std::string> GltfValue::keys() const {
  if (!json_->is_object()) throw error(std::string("it is a ") + json_->type_name(), "an object");
  std::vector<std::string> result;
  for (const auto& item : json_->items()) result.push_back(item.key());
  return result;
}

std::size_t GltfValue::size() const {
  if (!json_->is_array()) throw error(std::string("it is a ") + json_->type_name(), "a list");
  return json_->size();
}

GltfValue GltfValue::at(std::size_t index) const {
  return {(*json_)[index], pointer_ + "/" + std::to_string(index), file_};
}

std::uint64_t GltfValue::whole() const {
  constexpr double kLargest = 9007199254740992;  // 2⁵³: beyond, doubles skip integers
  if (json_->is_number_unsigned() && json_->get<std::uint64_t>() <= static_cast<std::uint64_t>(kLargest)) {
    return json_->get<std::uint64_t>();
  }
  if (json_->is_number_float()) {
    const double value = json_->get<double>();
    if (value >= 0 && value <= kLargest && value == static_cast<double>(static_cast<std::uint64_t>(value))) {
      return static_cast<std::uint64_t>(value);
    }
  }
  throw error(
      json_->is_number() ? json_->dump() + " is out of range" : std::string("it is a ") + json_->type_name(),
      "an integer from 0");
}

double GltfValue::number() const {
  if (!json_->is_number()) throw error(std::string("it is a ") + json_->type_name(), "a number");
  return json_->get<double>();
}

bool GltfValue::truth() const {
  if (!json_->is_boolean()) throw error(std::string("it is a ") + json_->type_name(), "true or false");
  return json_->get<bool>();
}

const std::string& GltfValue::text() const {
  if (!json_->is_string()) throw error(std::string("it is a ") + json_->type_name(), "a text");
  return json_->get_ref<const std::string&>();
}

std::vector<double> GltfValue::numbers(std::size_t count) const {
  if (size() != count) {
    throw error("it has " + std::to_string(size()) + " entries", std::to_string(count) + " numbers");
  }
  std::vector<double> result;
  for (std::size_t i = 0; i < count; ++i) result.push_back(at(i).number());
  return result;
}

std::uint64_t wholeOr(const GltfValue& object, std::string_view key, std::uint64_t otherwise) {
  const auto value = object.find(key);
  return value ? value->whole() : otherwise;
}

bool truthOr(const GltfValue& object, std::string_view key, bool otherwise) {
  const auto value = object.find(key);
  return value ? value->truth() : otherwise;
}

std::string textOr(const GltfValue& object, std::string_view key, const std::string& otherwise) {
  const auto value = object.find(key);
  return value ? value->text() : otherwise;
}

}  // namespace bakelight::formats
