#include "pipeline/variants.h"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "formats/error.h"

namespace bakelight::pipeline {
namespace {

constexpr const char* kSyntax = "stage.parameter=value,value,... or stage.parameter=first..last";
constexpr const char* kExample = "--vary transfer.order=2..6, for example";

// What one varied parameter may be.
struct Axis {
  std::string parameter;                      // without its stage
  std::vector<std::vector<Setting>> choices;  // the first setting of each is the varied one
};

// At `separator`, but not inside [lists].
std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  int depth = 0;
  for (const char c : text) {
    depth += c == '[' ? 1 : c == ']' ? -1 : 0;
    if (c == separator && depth == 0)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

std::optional<int> integer(const std::string& text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

// "2..4" as 2, 3, 4; anything else as it is.
std::vector<std::string> unrolled(const std::string& choice, const std::string& option) {
  const std::size_t dots = choice.find("..");
  if (dots == std::string::npos) return {choice};
  const auto first = integer(choice.substr(0, dots)), last = integer(choice.substr(dots + 2));
  if (!first || !last || *last < *first || *last - *first >= static_cast<int>(kMostVariants))
    throw Error(ExitStatus::kUsage, {option, "", ""}, "\"" + choice + "\" is no range of integers",
                "first..last, first not above last", kExample);
  std::vector<std::string> values;
  for (int value = *first; value <= *last; ++value) values.push_back(std::to_string(value));
  return values;
}

Axis parseAxis(const std::string& text) {
  const std::string option = "--vary " + text;
  const std::size_t equals = text.find('=');
  Axis axis;
  for (const std::string& choice : split(equals == std::string::npos ? "" : text.substr(equals + 1), ',')) {
    const std::vector<std::string> parts = split(choice, '+');
    for (const std::string& value : unrolled(parts.front(), option)) {
      std::vector<Setting> settings;
      try {
        if (value.empty()) throw Error(ExitStatus::kUsage, {}, "");
        settings.push_back(parseSetting(text.substr(0, equals + 1) + value));
        for (std::size_t i = 1; i < parts.size(); ++i) settings.push_back(parseSetting(parts[i]));
      } catch (const Error&) {
        throw Error(ExitStatus::kUsage, {option, "", ""}, "is nothing to vary", kSyntax, kExample);
      }
      for (Setting& setting : settings) setting.option = option;
      axis.choices.push_back(std::move(settings));
    }
  }
  axis.parameter = axis.choices.front().front().parameter;
  return axis;
}

void checkOnce(const std::vector<Axis>& axes) {
  std::set<std::string> varied;
  for (const Axis& axis : axes) {
    const Setting& setting = axis.choices.front().front();
    if (!varied.insert(setting.stage + "." + setting.parameter).second)
      throw Error(ExitStatus::kUsage, {setting.option, "", ""}, "varies a parameter for the second time",
                  "each parameter once, with all its values");
  }
}

// "order", or "transfer.order" if another stage's parameter of that name is varied, too.
std::string labelOf(const Setting& setting, const std::vector<Axis>& axes) {
  const auto same = std::count_if(axes.begin(), axes.end(),
                                  [&](const Axis& axis) { return axis.parameter == setting.parameter; });
  return same > 1 ? setting.stage + "." + setting.parameter : setting.parameter;
}

std::string nameFor(const Setting& setting, const std::vector<Axis>& axes) {
  std::string name = labelOf(setting, axes) + "=" + setting.value;
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
}

}  // namespace

std::vector<Variant> variantsOf(const std::vector<std::string>& vary) {
  std::vector<Axis> axes;
  for (const std::string& text : vary) axes.push_back(parseAxis(text));
  checkOnce(axes);
  std::vector<Variant> variants = {{"", {}}};
  for (const Axis& axis : axes) {
    std::vector<Variant> longer;
    for (const Variant& variant : variants)
      for (const std::vector<Setting>& choice : axis.choices) {
        longer.push_back(variant);
        Variant& last = longer.back();
        last.name += (last.name.empty() ? "" : ",") + nameFor(choice.front(), axes);
        last.settings.insert(last.settings.end(), choice.begin(), choice.end());
      }
    variants = std::move(longer);
    if (variants.size() > kMostVariants)
      throw Error(ExitStatus::kUsage, {axis.choices.front().front().option, "", ""},
                  "makes " + std::to_string(variants.size()) + " variants",
                  "at most " + std::to_string(kMostVariants), "vary less at a time");
  }
  if (axes.empty()) variants.front().name = "base";
  std::set<std::string> names;
  for (const Variant& variant : variants)
    if (!names.insert(variant.name).second)
      throw Error(ExitStatus::kUsage, {variant.settings.front().option, "", ""},
                  "makes the variant \"" + variant.name + "\" twice", "each value once");
  return variants;
}

formats::Json parametersOf(const Variant& variant) {
  formats::Json parameters = formats::Json::object();
  for (const Setting& setting : variant.settings) {
    const formats::Json value = formats::Json::parse(setting.value, nullptr, false);
    parameters[setting.stage + "." + setting.parameter] =
        value.is_discarded() ? formats::Json(setting.value) : value;
  }
  return parameters;
}

}  // namespace bakelight::pipeline
