// The tools that are installed, and what they say of themselves.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "formats/error.h"
#include "formats/tool_description.h"
#include "pipeline/disk.h"
#include "pipeline/memo.h"
#include "pipeline/runner.h"

namespace bakelight::pipeline {

struct InstalledTool {
  std::filesystem::path executable;
  std::string hash = "";  // of the executable's content
  formats::ToolDescription description = {};
};

class Toolbox {
 public:
  // `processor`: names the kind of processor, as a tool may choose its execution path by it.
  Toolbox(std::filesystem::path folder, std::string processor, Disk& disk, Runner& runner, Memo& memo);

  bool has(const std::string& name) const;
  // Asks the executable `folder`/`name` once for what --describe says. Throws Error(kNotAvailable) at `place`
  // if there is no such executable or it gives no description.
  const InstalledTool& require(const std::string& name, const ErrorPlace& place);

 private:
  InstalledTool examine(const std::string& name, const ErrorPlace& place);

  std::filesystem::path folder_;
  std::string processor_;
  Disk& disk_;
  Runner& runner_;
  Memo& memo_;
  std::map<std::string, InstalledTool> known_;
};

// Model and instruction sets of this machine's processor, hashed; "" where the system does not tell.
std::string processorIdentity();

}  // namespace bakelight::pipeline
