// Seconds by step, for a stage's stats.
#pragma once

#include <chrono>
#include <map>
#include <string>

namespace bakelight::stage {

class Stopwatch {
 public:
  // `seconds` outlives the stopwatch.
  explicit Stopwatch(std::map<std::string, double>& seconds) : seconds_(seconds) {}
  // Books the time since the last call, or the construction, under `step`.
  void lap(const std::string& step) {
    const auto now = std::chrono::steady_clock::now();
    seconds_[step] += std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }

 private:
  std::map<std::string, double>& seconds_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace bakelight::stage
