#include "pipeline/toolbox.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "formats/hash.h"
#include "formats/module.h"

namespace bakelight::pipeline {
using formats::Json;

Toolbox::Toolbox(std::filesystem::path folder, std::string processor, Disk& disk, Runner& runner, Memo& memo)
    : folder_(std::move(folder)),
      processor_(std::move(processor)),
      disk_(disk),
      runner_(runner),
      memo_(memo) {}

bool Toolbox::has(const std::string& name) const {
  return disk_.isFile(folder_ / name);
}

const InstalledTool& Toolbox::require(const std::string& name, const ErrorPlace& place) {
  const auto known = known_.find(name);
  if (known != known_.end()) return known->second;
  return known_.emplace(name, examine(name, place)).first->second;
}

InstalledTool Toolbox::examine(const std::string& name, const ErrorPlace& place) {
  InstalledTool tool{.executable = folder_ / name};
  if (!has(name))
    throw Error(ExitStatus::kNotAvailable, place, "there is no tool \"" + name + "\" in " + folder_.string(),
                "", "build it, or name the folder of the tools with --tools");
  tool.hash = memo_.hashOf(tool.executable);
  for (const std::filesystem::path& module : formats::modulesOf(folder_))
    if (disk_.isFile(module)) tool.hash = formats::contentHash(tool.hash + memo_.hashOf(module));

  // Two tools may share one executable that answers by the name it is called by.
  const std::string key = name + "/" + tool.hash + "/" + processor_;
  if (const auto answer = memo_.answer(key)) {
    tool.description = formats::toolDescriptionFromJson(*answer, tool.executable.string());
    return tool;
  }
  const Captured captured = runner_.capture({tool.executable.string(), "--describe"});
  const Json answer = Json::parse(captured.output, nullptr, false);
  if (captured.exit_status != 0 || captured.signal != 0 || !answer.is_object())
    throw Error(ExitStatus::kNotAvailable, {tool.executable.string(), "", ""}, "does not answer --describe",
                "", "run it by hand to see why");
  tool.description = formats::toolDescriptionFromJson(answer, tool.executable.string() + " --describe");
  memo_.rememberAnswer(key, answer);
  return tool;
}

std::string processorIdentity() {
  std::ifstream processors("/proc/cpuinfo");
  std::string text, line;
  while (std::getline(processors, line) && !line.empty())  // the first processor stands for all
    if (line.starts_with("model name") || line.starts_with("flags") || line.starts_with("Features"))
      text += line + "\n";
  return text.empty() ? "" : formats::contentHash(text);
}

}  // namespace bakelight::pipeline
