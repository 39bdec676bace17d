#include "formats/json_reader.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "formats/tool_description.h"

namespace bakelight::formats {
namespace {

const char* kindOf(const Json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return "a list";
  if (value.is_string()) return "a text";
  if (value.is_boolean()) return "true or false";
  return value.is_null() ? "null" : "a number";
}

// "order" of "/stages/transfer/order", "deliver/1" of "/deliver/1".
std::string nameAt(const std::string& pointer) {
  if (pointer.empty()) return "it";
  std::size_t slash = pointer.rfind('/');
  const bool is_index = pointer.find_first_not_of("0123456789", slash + 1) == std::string::npos;
  if (is_index && slash > 0) slash = pointer.rfind('/', slash - 1);
  return pointer.substr(slash + 1);
}

// Of the value that stands at `pointer`.
ParameterDescription ruleFor(const std::string& pointer, ParameterType type) {
  ParameterDescription rule;
  rule.name = nameAt(pointer);
  rule.type = type;
  return rule;
}

ParameterDescription ruleFor(const std::string& pointer, ParameterType type, JsonReader::Range range) {
  const JsonReader::Range all;
  ParameterDescription rule = ruleFor(pointer, type);
  if (range.minimum > all.minimum) rule.minimum = range.minimum;
  if (range.maximum < all.maximum) rule.maximum = range.maximum;
  return rule;
}

}  // namespace

JsonReader::JsonReader(const Json& value, std::string file, std::string pointer, std::string remedy)
    : JsonReader(value, std::make_shared<const Source>(Source{std::move(file), std::move(remedy)}),
                 std::move(pointer)) {}

JsonReader::JsonReader(const Json& value, std::shared_ptr<const Source> source, std::string pointer)
    : value_(&value), source_(std::move(source)), pointer_(std::move(pointer)) {}

Error JsonReader::error(const std::string& what, const std::string& expected, const std::string& remedy,
                        const std::string& element) const {
  return badInput({file(), element, pointer_}, what, expected, remedy.empty() ? source_->remedy : remedy);
}

Json JsonReader::checked(const ParameterDescription& rule) const {
  try {
    return checkParameter(rule, *value_, place());
  } catch (const Error& refused) {
    if (!refused.remedy().empty()) throw;
    throw error(refused.problem(), refused.expected());
  }
}

// --- the value itself ---

const std::string& JsonReader::text() const {
  if (!value_->is_string()) checked(ruleFor(pointer_, ParameterType::kText));
  return value_->get_ref<const std::string&>();
}

bool JsonReader::boolean() const {
  if (!value_->is_boolean()) checked(ruleFor(pointer_, ParameterType::kBoolean));
  return value_->get<bool>();
}

double JsonReader::number(Range range) const {
  const double number = value_->is_number() ? value_->get<double>() : std::nan("");
  if (number >= range.minimum && number <= range.maximum) return number;
  return checked(ruleFor(pointer_, ParameterType::kReal, range)).get<double>();
}

int JsonReader::integer(int minimum, int maximum) const {
  const Range range{static_cast<double>(minimum), static_cast<double>(maximum)};
  return checked(ruleFor(pointer_, ParameterType::kInteger, range)).get<int>();
}

std::uint64_t JsonReader::whole() const {
  constexpr double kLargest = 9007199254740992;  // 2⁵³: beyond, doubles skip integers
  const double number = value_->is_number() ? value_->get<double>() : -1;
  if (number >= 0 && number <= kLargest && number == std::floor(number))
    return static_cast<std::uint64_t>(number);
  throw error(
      value_->is_number() ? value_->dump() + " is out of range" : std::string("it is ") + kindOf(*value_),
      "an integer from 0");
}

Float3 JsonReader::float3(Range range) const {
  ParameterDescription rule = ruleFor(pointer_, ParameterType::kRealList, range);
  rule.length = 3;
  const Json list = checked(rule);
  return {list[0].get<float>(), list[1].get<float>(), list[2].get<float>()};
}

std::vector<double> JsonReader::numbers(std::size_t count) const {
  if (size() != count)
    throw error("it has " + std::to_string(size()) + " entries", std::to_string(count) + " numbers");
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i) numbers.push_back(at(i).number());
  return numbers;
}

std::vector<std::string> JsonReader::texts() const {
  std::vector<std::string> texts;
  for (const JsonReader& item : items()) texts.push_back(item.text());
  return texts;
}

std::size_t JsonReader::choiceAmong(const std::vector<std::string>& texts) const {
  ParameterDescription rule = ruleFor(pointer_, ParameterType::kText);
  rule.choices = texts;
  const auto text = checked(rule).get<std::string>();
  return static_cast<std::size_t>(std::find(texts.begin(), texts.end(), text) - texts.begin());
}

std::string JsonReader::oneOf(const std::vector<std::string>& texts) {
  ParameterDescription rule = ruleFor("", ParameterType::kText);
  rule.choices = texts;
  return expectation(rule);
}

// --- of a list ---

const Json& JsonReader::asList() const {
  if (!value_->is_array()) throw error(std::string("it is ") + kindOf(*value_), "a list [ ... ]");
  return *value_;
}

std::size_t JsonReader::size() const {
  return asList().size();
}

JsonReader JsonReader::at(std::size_t index) const {
  return {asList()[index], source_, childPointer(pointer_, std::to_string(index))};
}

std::vector<JsonReader> JsonReader::items() const {
  std::vector<JsonReader> items;
  for (std::size_t i = 0; i < size(); ++i) items.push_back(at(i));
  return items;
}

// --- of an object ---

const Json& JsonReader::asObject() const {
  if (!value_->is_object()) throw error(std::string("it is ") + kindOf(*value_), "a JSON object { ... }");
  return *value_;
}

const Json* JsonReader::member(std::string_view key) const {
  const auto found = asObject().find(key);
  if (std::find(asked_.begin(), asked_.end(), key) == asked_.end()) asked_.emplace_back(key);
  return found == value_->end() ? nullptr : &*found;
}

std::vector<std::string> JsonReader::keys() const {
  std::vector<std::string> keys;
  for (const auto& [key, unused] : asObject().items()) keys.push_back(key);
  return keys;
}

bool JsonReader::has(std::string_view key) const {
  return member(key) != nullptr;
}

ErrorPlace JsonReader::placeOf(std::string_view key) const {
  return {file(), "", childPointer(pointer_, key)};
}

std::optional<JsonReader> JsonReader::find(std::string_view key) const {
  const Json* found = member(key);
  if (found == nullptr) return std::nullopt;
  return JsonReader(*found, source_, childPointer(pointer_, key));
}

JsonReader JsonReader::at(std::string_view key, const std::string& expected) const {
  if (const Json* found = member(key)) return {*found, source_, childPointer(pointer_, key)};
  throw error("the key \"" + std::string(key) + "\" is missing", expected);
}

std::string JsonReader::text(std::string_view key, const std::string& otherwise) const {
  const auto found = find(key);
  return found ? found->text() : otherwise;
}

bool JsonReader::boolean(std::string_view key, bool otherwise) const {
  const auto found = find(key);
  return found ? found->boolean() : otherwise;
}

std::uint64_t JsonReader::whole(std::string_view key, std::uint64_t otherwise) const {
  const auto found = find(key);
  return found ? found->whole() : otherwise;
}

std::filesystem::path JsonReader::existingFile(std::string_view key, const std::string& expected,
                                               const std::string& remedy) const {
  const JsonReader name = at(key, expected);
  const std::filesystem::path path =
      (std::filesystem::path(file()).parent_path() / name.text()).lexically_normal();
  if (!std::filesystem::is_regular_file(path))
    throw name.error("there is no file " + path.string(), expected, remedy);
  return path;
}

std::vector<std::string> JsonReader::texts(std::string_view key) const {
  const auto found = find(key);
  return found ? found->texts() : std::vector<std::string>();
}

std::vector<JsonReader> JsonReader::items(std::string_view key) const {
  const auto found = find(key);
  return found ? found->items() : std::vector<JsonReader>();
}

JsonReader JsonReader::object(std::string_view key) const {
  static const Json kEmpty = Json::object();
  const Json* found = member(key);
  JsonReader object(found == nullptr ? kEmpty : *found, source_, childPointer(pointer_, key));
  object.asObject();
  return object;
}

void JsonReader::read(std::string_view key, bool& value) const {
  if (const auto found = find(key)) value = found->boolean();
}

void JsonReader::read(std::string_view key, int& value, Range range) const {
  if (const auto found = find(key))
    value = found->integer(static_cast<int>(range.minimum), static_cast<int>(range.maximum));
}

void JsonReader::read(std::string_view key, double& value, Range range) const {
  if (const auto found = find(key)) value = found->number(range);
}

void JsonReader::read(std::string_view key, Float3& value, Range range) const {
  if (const auto found = find(key)) value = found->float3(range);
}

void JsonReader::read(std::string_view key, std::string& value) const {
  if (const auto found = find(key)) value = found->text();
}

std::vector<Error> JsonReader::unknownKeys(const std::vector<std::string>& allowed) const {
  std::vector<Error> errors;
  for (const std::string& key : keys())
    if (std::find(allowed.begin(), allowed.end(), key) == allowed.end())
      errors.push_back(badInput(placeOf(key), "unknown key \"" + key + "\"", "one of: " + join(allowed, ", "),
                                suggestion(key, allowed)));
  return errors;
}

void JsonReader::allowKeys(const std::vector<std::string>& allowed) const {
  const std::vector<Error> errors = unknownKeys(allowed);
  if (!errors.empty()) throw errors.front();
}

}  // namespace bakelight::formats
