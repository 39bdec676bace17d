#include "tools/stage/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

namespace bakelight::stage {
namespace {

constexpr std::int64_t kRedrawInterval_ms = 100;
constexpr int kBarWidth = 28;

// 1234567 as "1.2 M".
std::string shortCount(double value) {
  const char* const suffixes[] = {"", " k", " M", " G"};
  int power = 0;
  while (value >= 1000 && power < 3) value /= 1000, ++power;
  return fmt::format("{:.{}f}{}", value, power == 0 ? 0 : 1, suffixes[power]);
}

std::string shortTime(double seconds) {
  if (seconds < 60) return fmt::format("{:.0f} s", seconds);
  const int whole = static_cast<int>(seconds);
  if (seconds < 3600) return fmt::format("{}:{:02} min", whole / 60, whole % 60);
  return fmt::format("{}:{:02} h", whole / 3600, whole / 60 % 60);
}

}  // namespace

ProgressStyle automaticProgressStyle() {
  return ::isatty(STDERR_FILENO) != 0 ? ProgressStyle::kBar : ProgressStyle::kLines;
}

Progress::Progress(ProgressStyle style, std::string label, std::uint64_t total, std::string unit)
    : style_(style),
      label_(std::move(label)),
      unit_(std::move(unit)),
      total_(total),
      start_(std::chrono::steady_clock::now()) {}

Progress::~Progress() {
  if (style_ == ProgressStyle::kBar && drawn_) std::fputs("\r\033[K", stderr);
}

void Progress::advance(std::uint64_t count) {
  const std::uint64_t done = done_.fetch_add(count, std::memory_order_relaxed) + count;
  if (style_ == ProgressStyle::kNone) return;

  const auto elapsed = std::chrono::steady_clock::now() - start_;
  const auto elapsed_ms = std::chrono::duration_cast<std::chrono::milliseconds>(elapsed).count();
  std::int64_t due = next_draw_ms_.load(std::memory_order_relaxed);
  if (done != total_ &&
      (elapsed_ms < due || !next_draw_ms_.compare_exchange_strong(due, elapsed_ms + kRedrawInterval_ms)))
    return;
  const std::lock_guard lock(drawing_);
  draw(done, std::chrono::duration<double>(elapsed).count());
}

void Progress::draw(std::uint64_t done, double elapsed_s) {
  const double rate_per_s = static_cast<double>(done) / std::max(elapsed_s, 1e-9);
  const double share =
      total_ > 0 ? std::min(1.0, static_cast<double>(done) / static_cast<double>(total_)) : 0;
  const double left_s = total_ > done ? static_cast<double>(total_ - done) / std::max(rate_per_s, 1e-9) : 0;
  const std::string figures = shortCount(rate_per_s) + " " + unit_ + "/s, " + shortTime(left_s) + " left";

  switch (style_) {
    case ProgressStyle::kBar: {
      const int filled = static_cast<int>(share * kBarWidth);
      const std::string bar = std::string(filled, '#') + std::string(kBarWidth - filled, '.');
      std::fprintf(stderr, "\r\033[K%s [%s] %3d%%  %s", label_.c_str(), bar.c_str(),
                   static_cast<int>(share * 100), figures.c_str());
      drawn_ = true;
      break;
    }
    case ProgressStyle::kLines: {
      const int tenths = static_cast<int>(share * 10);
      if (tenths <= drawn_tenths_ || tenths == 0) return;
      drawn_tenths_ = tenths;
      std::fprintf(stderr, "%s: %d%%, %s\n", label_.c_str(), tenths * 10, figures.c_str());
      break;
    }
    case ProgressStyle::kJson: {
      const nlohmann::json line = {{"progress",
                                    {{"label", label_},
                                     {"done", done},
                                     {"total", total_},
                                     {"unit", unit_},
                                     {"rate_per_s", rate_per_s},
                                     {"left_s", left_s}}}};
      std::fprintf(stderr, "%s\n", line.dump().c_str());
      break;
    }
    case ProgressStyle::kNone:
      break;
  }
  std::fflush(stderr);
}

}  // namespace bakelight::stage
