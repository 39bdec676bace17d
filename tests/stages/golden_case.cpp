#include "tests/stages/golden_case.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/json_reader.h"
#include "formats/mesh_ply.h"
#include "formats/words.h"
#include "tests/stages/scenes.h"

namespace bakelight::stages {

using formats::JsonReader;
namespace fs = std::filesystem;

namespace {

// --- case.json ---

std::string filledText(const JsonReader& object, const char* key) {
  const JsonReader text = object.at(key, "a text");
  if (text.text().empty()) throw text.error("is empty", "a text");
  return text.text();
}

std::vector<JsonReader> filledList(const JsonReader& object, const char* key) {
  std::vector<JsonReader> items = object.at(key, "a list").items();
  if (items.empty()) throw object.at(key).error("is empty", "a list");
  return items;
}

CaseInput inputFrom(const JsonReader& json) {
  json.allowKeys({"file", "scene", "subdivisions", "copy"});
  CaseInput input{filledText(json, "file"), json.text("scene", ""), json.text("copy", ""),
                  static_cast<int>(json.whole("subdivisions", 0))};
  if (input.scene.empty() == input.copy.empty()) throw json.error("has not exactly one of scene and copy");
  return input;
}

formats::CompareLimits limitsFrom(const JsonReader& json) {
  formats::CompareLimits limits;
  for (const auto& [name, value] : {std::pair("distance", &limits.distance),
                                    {"normal", &limits.normal},
                                    {"maximum", &limits.maximum},
                                    {"rms", &limits.rms},
                                    {"relative", &limits.relative}})
    json.read(name, *value, {.minimum = 0});
  limits.ignored_keys = json.texts("ignored_keys");
  json.refuseOthers();
  return limits;
}

CaseOutput outputFrom(const JsonReader& json) {
  json.allowKeys({"file", "kind", "limits", "reason"});
  CaseOutput output{filledText(json, "file"), filledText(json, "kind"), {}, ""};
  const auto& kinds = formats::comparedKinds();
  if (std::find(kinds.begin(), kinds.end(), output.kind) == kinds.end())
    throw json.at("kind").error("there is no comparison for " + output.kind, formats::join(kinds, ", "));
  if (!json.has("limits")) return output;
  output.limits = limitsFrom(json.at("limits"));
  output.reason = filledText(json, "reason");
  return output;
}

GoldenCase caseFrom(const JsonReader& json) {
  json.allowKeys({"about", "inputs", "commands", "scratch", "outputs"});
  filledText(json, "about");
  GoldenCase result;
  for (const JsonReader& input : filledList(json, "inputs")) result.inputs.push_back(inputFrom(input));
  for (const JsonReader& command : filledList(json, "commands")) result.commands.push_back(command.texts());
  result.scratch = json.texts("scratch");
  for (const JsonReader& output : filledList(json, "outputs")) result.outputs.push_back(outputFrom(output));
  return result;
}

// --- running ---

std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text.append(c == '\'' ? "'\\''" : std::string(1, c));
  return text + "'";
}

void runCommand(const std::vector<std::string>& command, const fs::path& tools_folder, const fs::path& work,
                int threads) {
  std::string line =
      "cd " + quoted(work.string()) + " && " + quoted((tools_folder / command.front()).string());
  for (std::size_t i = 1; i < command.size(); ++i) line.append(" ").append(quoted(command[i]));
  line += " --progress none --threads " + std::to_string(threads);
  const int status = std::system(line.c_str());
  const int exit_status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  if (exit_status == 0) return;
  const bool not_available = exit_status == static_cast<int>(ExitStatus::kNotAvailable);
  throw Error(not_available ? ExitStatus::kNotAvailable : ExitStatus::kBadInput, {},
              command.front() + " ended with status " + std::to_string(exit_status), "status 0",
              "run it by hand: " + line);
}

std::set<std::string> filesIn(const fs::path& folder) {
  std::set<std::string> names;
  if (!fs::is_directory(folder)) return names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (!entry.is_directory()) names.insert(fs::relative(entry.path(), folder).string());
  return names;
}

void checkFiles(const fs::path& folder, const std::set<std::string>& expected, const std::string& remedy) {
  const std::set<std::string> present = filesIn(folder);
  for (const std::string& name : expected)
    if (!present.contains(name)) throw badInput({(folder / name).string(), "", ""}, "is missing", "", remedy);
  for (const std::string& name : present)
    if (!expected.contains(name))
      throw badInput({(folder / name).string(), "", ""}, "is there, but case.json does not name it", "",
                     remedy);
}

}  // namespace

GoldenCase readCase(const fs::path& folder) {
  const fs::path file = folder / "case.json";
  const formats::Json json = formats::readJson(file);
  GoldenCase result = caseFrom(JsonReader(json, file.string()));
  result.folder = folder;
  return result;
}

void runCase(const GoldenCase& golden_case, const fs::path& tools_folder, const fs::path& work, int threads) {
  std::set<std::string> expected(golden_case.scratch.begin(), golden_case.scratch.end());
  for (const CaseInput& input : golden_case.inputs) {
    expected.insert(input.file);
    if (input.copy.empty())
      formats::writePly(work / input.file, makeScene(input.scene, input.subdivisions));
    else
      formats::writeFileAtomically(work / input.file, formats::readFile(golden_case.folder / input.copy));
  }
  for (const CaseOutput& output : golden_case.outputs) expected.insert(output.file);
  for (const auto& command : golden_case.commands) runCommand(command, tools_folder, work, threads);
  checkFiles(work, expected, "name every file of the case under inputs, scratch or outputs");
}

std::vector<OutputComparison> compareWithGolden(const GoldenCase& golden_case, const fs::path& work) {
  std::set<std::string> expected;
  for (const CaseOutput& output : golden_case.outputs) expected.insert(output.file);
  checkFiles(golden_case.goldenFolder(), expected,
             "make golden-update CASE=" + golden_case.folder.filename().string());

  std::vector<OutputComparison> comparisons;
  for (const CaseOutput& output : golden_case.outputs)
    comparisons.push_back(
        {output.file, formats::compareFiles(output.kind, work / output.file,
                                            golden_case.goldenFolder() / output.file, output.limits)});
  return comparisons;
}

std::vector<std::string> differingFiles(const GoldenCase& golden_case, const fs::path& a, const fs::path& b) {
  std::vector<std::string> differing;
  const auto compareBytes = [&](const std::string& file) {
    if (formats::readFile(a / file) != formats::readFile(b / file)) differing.push_back(file);
  };
  for (const CaseOutput& output : golden_case.outputs) {
    if (output.kind != "json") {
      compareBytes(output.file);
      continue;
    }
    formats::CompareLimits equal;
    equal.ignored_keys = output.limits.ignored_keys;
    if (!formats::compareFiles("json", a / output.file, b / output.file, equal).passes())
      differing.push_back(output.file);
  }
  for (const std::string& file : golden_case.scratch) compareBytes(file);
  return differing;
}

std::string asText(const OutputComparison& output) {
  const formats::Comparison& comparison = output.comparison;
  std::string text = output.file + ": " + (comparison.passes() ? "within its limits" : "DIFFERS") + ", " +
                     std::to_string(comparison.compared_values) + " values compared\n";
  for (const std::string& mismatch : comparison.mismatches) text.append("  ✗ ").append(mismatch).append("\n");
  for (const formats::Difference& difference : comparison.differences) {
    text += fmt::format("  {} {:12.4g} of {:<12.4g}{}\n", difference.passes() ? "✓" : "✗",
                        difference.measured, difference.limit, difference.what);
  }
  return text;
}

}  // namespace bakelight::stages
