#include "formats/tool_description.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "formats/words.h"

namespace bakelight::formats {
namespace {

constexpr Word<ParameterType> kTypes[] = {
    {"boolean", ParameterType::kBoolean},    {"integer", ParameterType::kInteger},
    {"real", ParameterType::kReal},          {"text", ParameterType::kText},
    {"real_list", ParameterType::kRealList},
};

template <class Items>
auto findByName(const Items& items, std::string_view name) -> decltype(items.data()) {
  const auto found =
      std::find_if(items.begin(), items.end(), [&](const auto& item) { return item.name == name; });
  return found == items.end() ? nullptr : &*found;
}

// 10 rather than 10.0, 0.5 rather than 0.500000.
std::string shortNumber(double value) {
  if (value == std::floor(value) && std::abs(value) < 1e15)
    return std::to_string(static_cast<std::int64_t>(value));
  return Json(value).dump();
}

std::string rangeText(const ParameterDescription& parameter) {
  if (parameter.minimum && parameter.maximum)
    return " from " + shortNumber(*parameter.minimum) + " to " + shortNumber(*parameter.maximum);
  if (parameter.minimum) return " of " + shortNumber(*parameter.minimum) + " or more";
  if (parameter.maximum) return " of " + shortNumber(*parameter.maximum) + " or less";
  return "";
}

bool inRange(const ParameterDescription& parameter, double value) {
  return std::isfinite(value) && !(parameter.minimum && value < *parameter.minimum) &&
         !(parameter.maximum && value > *parameter.maximum);
}

// In a message; what is long by its kind.
std::string shown(const Json& value) {
  constexpr std::size_t kLongest = 80;
  const std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.size() <= kLongest || !(value.is_structured() || value.is_string())) return text;
  return value.is_object() ? "an object" : value.is_array() ? "a list" : "a long text";
}

[[noreturn]] void refuse(const ParameterDescription& parameter, const Json& value, const ErrorPlace& place,
                         const std::string& why, const std::string& remedy = "") {
  throw badInput(place, shown(value) + " " + why + " for " + parameter.name, expectation(parameter), remedy);
}

double checkedReal(const ParameterDescription& parameter, const Json& value, const Json& whole,
                   const ErrorPlace& place) {
  if (!value.is_number()) refuse(parameter, whole, place, "has the wrong type");
  const double number = value.get<double>();
  if (!inRange(parameter, number)) refuse(parameter, whole, place, "is out of range");
  return number;
}

Json checkedChoice(const ParameterDescription& parameter, const Json& value, const ErrorPlace& place) {
  const auto text = value.get<std::string>();
  const auto& choices = parameter.choices;
  if (std::find(choices.begin(), choices.end(), text) != choices.end()) return value;
  const std::string nearest = nearestName(text, choices);
  refuse(parameter, value, place, "is not a choice", nearest.empty() ? "" : "\"" + nearest + "\"");
}

std::string textOrEmpty(const Json& json, const char* key) {
  return json.value(key, std::string());
}

Json toJson(const std::vector<PortDescription>& ports) {
  Json list = Json::array();
  for (const auto& port : ports) {
    list.push_back(
        {{"name", port.name}, {"kind", port.kind}, {"required", port.required}, {"help", port.help}});
    if (!port.parts.empty()) list.back()["parts"] = port.parts;
  }
  return list;
}

Json toJson(const ParameterDescription& parameter) {
  Json json = {{"name", parameter.name},
               {"type", wordFor(kTypes, parameter.type)},
               {"default", parameter.default_value},
               {"help", parameter.help}};
  if (parameter.minimum) json["minimum"] = *parameter.minimum;
  if (parameter.maximum) json["maximum"] = *parameter.maximum;
  if (!parameter.choices.empty()) json["choices"] = parameter.choices;
  if (!parameter.unit.empty()) json["unit"] = parameter.unit;
  if (parameter.type == ParameterType::kRealList) json["length"] = parameter.length;
  if (parameter.changes_object) json["changes_object"] = true;
  return json;
}

std::vector<PortDescription> portsFromJson(const Json& list) {
  std::vector<PortDescription> ports;
  for (const auto& port : list)
    ports.push_back({port.at("name"), port.at("kind"), port.at("required"), textOrEmpty(port, "help"),
                     port.value("parts", std::vector<std::string>())});
  return ports;
}

ParameterDescription parameterFromJson(const Json& json) {
  ParameterDescription parameter;
  parameter.name = json.at("name");
  const std::string type = json.at("type");
  const ParameterType* known = valueFor(kTypes, type);
  if (known == nullptr) throw std::invalid_argument("unknown parameter type " + type);
  parameter.type = *known;
  parameter.default_value = json.at("default");
  if (json.contains("minimum")) parameter.minimum = json["minimum"].get<double>();
  if (json.contains("maximum")) parameter.maximum = json["maximum"].get<double>();
  parameter.choices = json.value("choices", std::vector<std::string>());
  parameter.length = json.value("length", 1);
  parameter.unit = textOrEmpty(json, "unit");
  parameter.help = textOrEmpty(json, "help");
  parameter.changes_object = json.value("changes_object", false);
  return parameter;
}

}  // namespace

const ParameterDescription* ToolDescription::findParameter(std::string_view name) const {
  return findByName(parameters, name);
}
const RetiredParameter* ToolDescription::findRetired(std::string_view name) const {
  return findByName(retired, name);
}
const PortDescription* ToolDescription::findInput(std::string_view name) const {
  return findByName(inputs, name);
}
const PortDescription* ToolDescription::findOutput(std::string_view name) const {
  return findByName(outputs, name);
}

std::string expectation(const ParameterDescription& parameter) {
  switch (parameter.type) {
    case ParameterType::kBoolean:
      return "true or false";
    case ParameterType::kInteger:
      return "an integer" + rangeText(parameter);
    case ParameterType::kReal: {
      std::string text = "a number" + rangeText(parameter);
      for (const auto& choice : parameter.choices) text.append(", or \"").append(choice).append("\"");
      return text;
    }
    case ParameterType::kRealList:
      return "a list of " + std::to_string(parameter.length) + " numbers" + rangeText(parameter);
    case ParameterType::kText:
      break;
  }
  if (parameter.choices.empty()) return "a text";
  std::string text = "one of";
  for (const auto& choice : parameter.choices)
    text += (&choice == parameter.choices.data() ? " \"" : ", \"") + choice + "\"";
  return text;
}

Json checkParameter(const ParameterDescription& parameter, const Json& value, const ErrorPlace& place) {
  switch (parameter.type) {
    case ParameterType::kBoolean:
      if (!value.is_boolean()) refuse(parameter, value, place, "has the wrong type");
      return value;
    case ParameterType::kInteger:
      if (!value.is_number_integer()) refuse(parameter, value, place, "has the wrong type");
      if (!inRange(parameter, value.get<double>())) refuse(parameter, value, place, "is out of range");
      return value.get<std::int64_t>();
    case ParameterType::kReal:
      if (value.is_string() && !parameter.choices.empty()) return checkedChoice(parameter, value, place);
      return checkedReal(parameter, value, value, place);
    case ParameterType::kRealList: {
      if (!value.is_array() || value.size() != static_cast<std::size_t>(parameter.length))
        refuse(parameter, value, place, "has the wrong shape");
      Json list = Json::array();
      for (const auto& element : value) list.push_back(checkedReal(parameter, element, value, place));
      return list;
    }
    case ParameterType::kText:
      break;
  }
  if (!value.is_string()) refuse(parameter, value, place, "has the wrong type");
  return parameter.choices.empty() ? value : checkedChoice(parameter, value, place);
}

Json checkParameters(const ToolDescription& tool, const Json& values, const ErrorPlace& place) {
  if (!values.is_object())
    throw badInput(place, "is not an object", "an object with parameters of " + tool.tool,
                   "{\"parameter\": value}");
  Json canonical = Json::object();
  for (const auto& [name, value] : values.items()) {
    ErrorPlace here = place;
    here.pointer = childPointer(place.pointer, name);
    const ParameterDescription* parameter = tool.findParameter(name);
    if (const RetiredParameter* was = tool.findRetired(name); was != nullptr && parameter == nullptr)
      throw badInput(here, "\"" + name + "\" is a parameter of " + tool.tool + " no more", "", was->instead);
    if (parameter == nullptr) {
      std::vector<std::string> names;
      for (const auto& known : tool.parameters) names.push_back(known.name);
      const std::string nearest = nearestName(name, names);
      throw badInput(here, "the tool " + tool.tool + " has no parameter \"" + name + "\"", "",
                     nearest.empty() ? tool.tool + " --help for the list" : "\"" + nearest + "\"");
    }
    canonical[name] = checkParameter(*parameter, value, here);
  }
  return canonical;
}

Json toJson(const ToolDescription& tool) {
  Json parameters = Json::array(), retired = Json::array();
  for (const auto& parameter : tool.parameters) parameters.push_back(toJson(parameter));
  for (const auto& was : tool.retired) retired.push_back({{"name", was.name}, {"instead", was.instead}});
  return {{"tool", tool.tool},
          {"summary", tool.summary},
          {"execution_path", tool.execution_path},
          {"inputs", toJson(tool.inputs)},
          {"outputs", toJson(tool.outputs)},
          {"parameters", parameters},
          {"retired", retired}};
}

ToolDescription toolDescriptionFromJson(const Json& json, const std::string& file) {
  try {
    ToolDescription tool;
    tool.tool = json.at("tool");
    tool.summary = textOrEmpty(json, "summary");
    tool.execution_path = textOrEmpty(json, "execution_path");
    tool.inputs = portsFromJson(json.at("inputs"));
    tool.outputs = portsFromJson(json.at("outputs"));
    for (const auto& parameter : json.at("parameters"))
      tool.parameters.push_back(parameterFromJson(parameter));
    for (const auto& was : json.value("retired", Json::array()))
      tool.retired.push_back({was.at("name"), was.at("instead")});
    return tool;
  } catch (const std::exception& error) {
    throw badInput({file, "", ""},
                   std::string("its --describe answer is not a tool description: ") + error.what(),
                   "the JSON of docs/FORMATS.md", "rebuild the tool");
  }
}

}  // namespace bakelight::formats
