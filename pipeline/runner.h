// Starts tools and tells what becomes of them. The scheduler knows this interface only; its tests answer in
// memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "formats/error.h"

namespace bakelight::pipeline {

using Job = std::size_t;  // chosen by the caller, unique among the jobs that run

// A tool's own words on how far it is; done <= total, total 0 if unknown.
struct ToolProgress {
  std::string label, unit;
  double done = 0, total = 0, rate_per_s = 0;
  double left_s = -1;  // < 0 if unknown
};
struct ToolWarning {
  std::string text;
};
struct ToolText {  // a line that is not of the contract
  std::string line;
};
struct ToolFinished {
  int exit_status = 0;
  int signal = 0;  // that killed it, or 0
  double wall_s = 0, cpu_s = 0;
  std::uint64_t peak_memory_bytes = 0;
  std::optional<Error> error = {};  // as the tool told it
};
struct Interrupted {};  // someone asked this process to stop

struct Event {
  Job job = 0;  // of no meaning for Interrupted
  std::variant<ToolProgress, ToolWarning, ToolText, ToolFinished, Interrupted> what;
};

struct Captured {
  int exit_status = 0;
  int signal = 0;
  std::string output;  // standard output
};

class Runner {
 public:
  virtual ~Runner() = default;

  // Throws Error(kNotAvailable) if the program cannot be started.
  virtual void start(Job job, const std::vector<std::string>& command) = 0;
  // The next thing that happened, or nothing within `timeout_ms`. Each started job ends in one ToolFinished.
  virtual std::optional<Event> wait(int timeout_ms) = 0;
  // Asks all running jobs to end, by force after a while. Each still ends in a ToolFinished.
  virtual void stopAll() = 0;
  virtual bool interrupted() const = 0;

  // Runs to the end with nothing else in between; for --describe.
  virtual Captured capture(const std::vector<std::string>& command) = 0;
};

// One line of a tool's standard error in the form of --progress json. An error comes back as Error, for the
// caller to keep until the tool finishes.
std::variant<ToolProgress, ToolWarning, ToolText, Error> parseToolLine(std::string_view line);

}  // namespace bakelight::pipeline
