// What a tool says of itself with --describe: inputs, outputs and parameters, machine-readable. The tool's
// command line is built from it (tools/stage), and the driver checks recipes and assets against it
// (pipeline), so a parameter is declared once and judged by one rule everywhere.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/json.h"

namespace bakelight::formats {

enum class ParameterType {
  kBoolean,
  kInteger,   // 64-bit signed
  kReal,      // finite double; a JSON integer is accepted; or one of `choices`, where there are any
  kText,      // one of `choices` when there are any, else any text
  kRealList,  // fixed length, each element within the range
};

struct ParameterDescription {
  std::string name;  // snake_case; on the command line --snake-case
  ParameterType type = ParameterType::kBoolean;
  Json default_value;
  std::optional<double> minimum, maximum;  // inclusive
  std::vector<std::string> choices;        // kText; words that stand for a number, of kReal
  int length = 1;                          // kRealList only
  std::string unit;                        // "deg", "px", "triangles"; "" if dimensionless
  std::string help;                        // one line, no final full stop
  // The object itself is another one with another value: pictures of the two cannot be compared.
  bool changes_object = false;
};

// The kind of an input that takes files of every kind.
inline constexpr const char* kAnyKind = "any";

// A file that a tool reads or writes.
struct PortDescription {
  std::string name;  // snake_case; on the command line --name PATH
  std::string kind;  // "mesh", "image", "tensors", "pack", "report", kAnyKind
  bool required = true;
  std::string help;
  // Kind "material": the members that the tool looks at, as formats::toJson(Materials) has them; the driver
  // hands over no others, so that the rest may change without this. Empty: all.
  std::vector<std::string> parts = {};
};

// What used to be a parameter.
struct RetiredParameter {
  std::string name;
  std::string instead;  // where its value is written now
};

struct ToolDescription {
  std::string tool;
  std::string summary;
  // Names everything besides inputs and parameters that may change an output: for example the instruction set
  // that a ray tracer picks at run time. Part of the cache key, beside the hash of the executable. May be
  // empty.
  std::string execution_path;
  std::vector<PortDescription> inputs, outputs;
  std::vector<ParameterDescription> parameters;
  std::vector<RetiredParameter> retired;

  const ParameterDescription* findParameter(std::string_view name) const;
  const RetiredParameter* findRetired(std::string_view name) const;
  const PortDescription* findInput(std::string_view name) const;
  const PortDescription* findOutput(std::string_view name) const;
};

// "an integer from 1 to 10", "one of: shadowed, unshadowed", "3 numbers from 0 to 1".
std::string expectation(const ParameterDescription& parameter);

// The value in canonical form (an integer given for a real becomes a real), or Error(kBadInput) at `place`.
Json checkParameter(const ParameterDescription& parameter, const Json& value, const ErrorPlace& place);

// Checks each member of `values` (an object) against the tool's parameters; an unknown key is an error that
// names the nearest valid one, or what took its place. `place.pointer` points to `values`. Returns the
// canonical values, without defaults filled in.
Json checkParameters(const ToolDescription& tool, const Json& values, const ErrorPlace& place);

Json toJson(const ToolDescription& tool);
ToolDescription toolDescriptionFromJson(const Json& json, const std::string& file);

}  // namespace bakelight::formats
