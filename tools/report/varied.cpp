#include "tools/report/varied.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "tools/report/text.h"

namespace bakelight::report {
namespace {

VariedParameter parameterOf(const Plan& plan, const std::string& name) {
  VariedParameter parameter{name, {}, {}, false};
  for (const PlanVariant& variant : plan.variants) {
    const auto found = variant.parameters.find(name);
    const bool there = found != variant.parameters.end();
    if (there && found->is_string()) parameter.is_text = true;
    const std::string value = there ? valueText(*found) : "–";
    const auto known = std::find(parameter.values.begin(), parameter.values.end(), value);
    parameter.value_of.push_back(static_cast<std::size_t>(known - parameter.values.begin()));
    if (known == parameter.values.end()) parameter.values.push_back(value);
  }
  return parameter;
}

// Whether variants that share a value of `known` share that of `parameter`, too: settings that go together.
bool follows(const VariedParameter& parameter, const VariedParameter& known) {
  std::map<std::size_t, std::size_t> value_from_known;
  for (std::size_t v = 0; v < parameter.value_of.size(); ++v)
    if (value_from_known.emplace(known.value_of[v], parameter.value_of[v]).first->second !=
        parameter.value_of[v])
      return false;
  return true;
}

}  // namespace

Varied variedParameters(const Plan& plan, std::size_t most_values) {
  std::set<std::string> names;
  for (const PlanVariant& variant : plan.variants)
    for (const auto& [name, unused] : variant.parameters.items()) names.insert(name);
  Varied varied;
  for (const std::string& name : names) {
    VariedParameter parameter = parameterOf(plan, name);
    if (parameter.values.size() > 1) varied.parameters.push_back(std::move(parameter));
  }
  varied.shown = varied.parameters.size();
  for (std::size_t p = 0; p < varied.parameters.size(); ++p) {
    const VariedParameter& parameter = varied.parameters[p];
    if (parameter.values.size() > most_values) continue;
    const auto rank = [](const VariedParameter& x) { return std::pair(x.is_text, x.values.size()); };
    if (!varied.hasShown() || rank(parameter) > rank(varied.parameters[varied.shown])) varied.shown = p;
  }
  return varied;
}

std::vector<std::size_t> labelParameters(const Varied& varied) {
  std::vector<std::size_t> parameters;
  for (std::size_t p = 0; p < varied.parameters.size(); ++p)
    if (!varied.hasShown() || !follows(varied.parameters[p], varied.parameters[varied.shown]))
      parameters.push_back(p);
  return parameters;
}

std::string shortLabel(const Plan& plan, const Varied& varied, std::size_t variant) {
  const auto valueOf = [&](std::size_t p) {
    const VariedParameter& parameter = varied.parameters[p];
    return parameter.values[parameter.value_of[variant]];
  };
  std::string label;
  for (const std::size_t p : labelParameters(varied)) label += (label.empty() ? "" : " · ") + valueOf(p);
  if (!label.empty()) return label;
  return varied.hasShown() ? valueOf(varied.shown) : plan.variants[variant].name;
}

std::string groupText(const Plan& plan, const Varied& varied, const std::vector<std::size_t>& group) {
  if (group.size() == plan.variants.size()) return "all";
  std::string text;
  for (const VariedParameter& parameter : varied.parameters) {
    const std::size_t value = parameter.value_of[group.front()];
    const bool common = std::all_of(group.begin(), group.end(), [&](std::size_t variant) {
      return parameter.value_of[variant] == value;
    });
    if (common) text += (text.empty() ? "" : ", ") + parameter.name + '=' + parameter.values[value];
  }
  if (!text.empty()) return text;
  for (const std::size_t variant : group) text += (text.empty() ? "" : ", ") + plan.variants[variant].name;
  return text;
}

}  // namespace bakelight::report
