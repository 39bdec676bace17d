// Progress of a long loop, drawn as a bar with rate and time left on a terminal, as one line per 10%
// otherwise, and as JSON lines for the driver.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace bakelight::stage {

enum class ProgressStyle { kBar, kLines, kJson, kNone };

// kBar if standard error is a terminal, else kLines.
ProgressStyle automaticProgressStyle();

class Progress {
 public:
  // `unit` in the plural: "vertices". A total of 0 means unknown. Draws nothing before the first advance.
  Progress(ProgressStyle style, std::string label, std::uint64_t total, std::string unit);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // From any thread; costs an atomic addition, and a redraw at most ten times a second.
  void advance(std::uint64_t count = 1);

 private:
  void draw(std::uint64_t done, double elapsed_s);

  const ProgressStyle style_;
  const std::string label_, unit_;
  const std::uint64_t total_;
  const std::chrono::steady_clock::time_point start_;
  std::atomic<std::uint64_t> done_{0};
  std::atomic<std::int64_t> next_draw_ms_{0};
  std::mutex drawing_;
  int drawn_tenths_ = -1;
  bool drawn_ = false;
};

}  // namespace bakelight::stage
