#include "tests/stages/golden_case.h"

#include <sys/wait.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/json.h"
#include "formats/mesh_ply.h"
#include "tests/stages/scenes.h"

namespace bakelight::stages {

using formats::Json;
namespace fs = std::filesystem;

namespace {

// --- case.json ---

class CaseReader {
 public:
  explicit CaseReader(std::string file) : file_(std::move(file)) {}

  GoldenCase read(const Json& json) const {
    checkKeys(json, "", {"about", "inputs", "commands", "scratch", "outputs"});
    text(json, "about", "");
    GoldenCase result;
    for (std::size_t i = 0; i < list(json, "inputs").size(); ++i)
      result.inputs.push_back(input(json["inputs"][i], "/inputs/" + std::to_string(i)));
    for (const Json& command : list(json, "commands"))
      result.commands.push_back(command.get<std::vector<std::string>>());
    if (json.contains("scratch")) result.scratch = json["scratch"].get<std::vector<std::string>>();
    for (std::size_t i = 0; i < list(json, "outputs").size(); ++i)
      result.outputs.push_back(output(json["outputs"][i], "/outputs/" + std::to_string(i)));
    return result;
  }

 private:
  Error error(const std::string& pointer, const std::string& what, const std::string& expected = "") const {
    return badInput({file_, "", pointer}, what, expected);
  }

  void checkKeys(const Json& json, const std::string& pointer, const std::set<std::string>& known) const {
    if (!json.is_object()) throw error(pointer, "is no object");
    for (const auto& [key, value] : json.items())
      if (!known.contains(key))
        throw error(formats::childPointer(pointer, key), "is an unknown key",
                    formats::nearestName(key, known));
  }

  std::string text(const Json& json, const char* key, const std::string& pointer) const {
    if (!json.contains(key) || !json[key].is_string() || json[key].get<std::string>().empty())
      throw error(formats::childPointer(pointer, key), "is missing", "a text");
    return json[key].get<std::string>();
  }

  const Json& list(const Json& json, const char* key) const {
    if (!json.contains(key) || !json[key].is_array() || json[key].empty())
      throw error(formats::childPointer("", key), "is missing or empty", "a list");
    return json[key];
  }

  CaseInput input(const Json& json, const std::string& pointer) const {
    checkKeys(json, pointer, {"file", "scene", "subdivisions", "copy"});
    CaseInput result{text(json, "file", pointer), json.value("scene", ""), json.value("copy", ""),
                     json.value("subdivisions", 0)};
    if (result.scene.empty() == result.copy.empty())
      throw error(pointer, "has not exactly one of scene and copy");
    return result;
  }

  CaseOutput output(const Json& json, const std::string& pointer) const {
    checkKeys(json, pointer, {"file", "kind", "limits", "reason"});
    CaseOutput result{text(json, "file", pointer), text(json, "kind", pointer), {}, ""};
    const auto& kinds = formats::comparedKinds();
    if (std::find(kinds.begin(), kinds.end(), result.kind) == kinds.end())
      throw error(pointer + "/kind", "there is no comparison for " + result.kind);
    if (!json.contains("limits")) return result;
    result.limits = limits(json["limits"], pointer + "/limits");
    result.reason = text(json, "reason", pointer);
    return result;
  }

  formats::CompareLimits limits(const Json& json, const std::string& pointer) const {
    checkKeys(json, pointer, {"distance", "normal", "maximum", "rms", "relative", "ignored_keys"});
    formats::CompareLimits result;
    result.distance = json.value("distance", 0.0);
    result.normal = json.value("normal", 0.0);
    result.maximum = json.value("maximum", 0.0);
    result.rms = json.value("rms", 0.0);
    result.relative = json.value("relative", 0.0);
    result.ignored_keys = json.value("ignored_keys", std::vector<std::string>());
    return result;
  }

  std::string file_;
};

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
  GoldenCase result = CaseReader(file.string()).read(formats::readJson(file));
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
    char figures[96];
    std::snprintf(figures, sizeof figures, "%12.4g of %-12.4g", difference.measured, difference.limit);
    text += std::string(difference.passes() ? "  ✓ " : "  ✗ ") + figures + difference.what + "\n";
  }
  return text;
}

}  // namespace bakelight::stages
