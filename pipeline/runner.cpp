#include "pipeline/runner.h"

#include <nlohmann/json.hpp>

namespace bakelight::pipeline {
using Json = nlohmann::json;
namespace {

ToolProgress progressFrom(const Json& json) {
  const auto number = [&](const char* key, double fallback) {
    const auto found = json.find(key);
    return found != json.end() && found->is_number() ? found->get<double>() : fallback;
  };
  return {.label = json.value("label", ""),
          .unit = json.value("unit", ""),
          .done = number("done", 0),
          .total = number("total", 0),
          .rate_per_s = number("rate_per_s", 0),
          .left_s = number("left_s", -1)};
}

Error errorFrom(const Json& json) {
  return {static_cast<ExitStatus>(json.value("status", static_cast<int>(ExitStatus::kBadInput))),
          {json.value("file", ""), json.value("element", ""), json.value("pointer", "")},
          json.value("problem", ""),
          json.value("expected", ""),
          json.value("remedy", "")};
}

}  // namespace

std::variant<ToolProgress, ToolWarning, ToolText, Error> parseToolLine(std::string_view line) {
  const Json json = Json::parse(line, nullptr, false);
  try {
    if (json.is_object() && json.contains("progress")) return progressFrom(json.at("progress"));
    if (json.is_object() && json.contains("warning"))
      return ToolWarning{json.at("warning").get<std::string>()};
    if (json.is_object() && json.contains("error")) return errorFrom(json.at("error"));
  } catch (const Json::exception&) {
    // Looked like the contract but is not: pass it on as it is.
  }
  return ToolText{std::string(line)};
}

}  // namespace bakelight::pipeline
