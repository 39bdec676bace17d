#include "pipeline/console.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "formats/words.h"

namespace bakelight::pipeline {
namespace {

constexpr auto kRedraw = std::chrono::milliseconds(100);
constexpr std::size_t kMaxLabelWidth = 40, kMaxListed = 10;
constexpr int kBarWidth = 20;
constexpr const char* kEraseLine = "\r\x1b[K";

std::string inParentheses(const std::string& text) {
  return text.empty() ? "" : " (" + text + ")";
}

std::string counted(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string rateText(double rate_per_s, const std::string& unit) {
  if (rate_per_s >= 1e6) return fmt::format("{:.1f}M {}/s", rate_per_s / 1e6, unit);
  if (rate_per_s >= 1e4) return fmt::format("{:.0f}k {}/s", rate_per_s / 1e3, unit);
  return fmt::format("{:.0f} {}/s", rate_per_s, unit);
}

std::string progressText(const ToolProgress& progress) {
  std::string text = progress.label;
  if (progress.total > 0) {
    const double fraction = std::clamp(progress.done / progress.total, 0.0, 1.0);
    text.append(" ").append(barText(fraction, kBarWidth)).append(fmt::format(" {:.0f}%", 100 * fraction));
  }
  if (progress.rate_per_s > 0) text.append("  ").append(rateText(progress.rate_per_s, progress.unit));
  if (progress.left_s >= 0) text.append("  ").append(durationText(progress.left_s)).append(" left");
  return text;
}

}  // namespace

std::string durationText(double seconds) {
  if (seconds < 59.95) return fmt::format("{:.1f} s", seconds);
  const auto whole = std::llround(seconds);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

std::string barText(double fraction, int width) {
  const int filled = static_cast<int>(fraction * width);
  std::string bar = "▕";
  for (int i = 0; i < width; ++i) bar += i < filled ? "█" : " ";
  return bar + "▏";
}

Console::Console(const Graph& graph, std::ostream& lines, std::ostream& errors, bool live)
    : graph_(graph), lines_(lines), errors_(errors), live_(live) {
  for (TaskIndex task = 0; task < graph.tasks.size(); ++task) {
    if (!graph.tasks[task].left_out.empty()) continue;
    label_width_ = std::max(label_width_, graph.nameOf(task).size());
    ++stage_count_;
  }
  label_width_ = std::min(label_width_, kMaxLabelWidth);
}

std::string Console::label(TaskIndex task) const {
  std::string name = graph_.nameOf(task);
  name.resize(std::max(name.size(), label_width_), ' ');
  return name + "  ";
}

void Console::started(TaskIndex task) {
  running_[task] = {};
  latest_ = task;
  drawLive();
}

void Console::progressed(TaskIndex task, const ToolProgress& progress) {
  running_[task] = progress;
  latest_ = task;
  drawLive();
}

void Console::said(TaskIndex task, const std::string& text) {
  line(label(task) + text);
}

void Console::settled(TaskIndex task, const Outcome& outcome) {
  if (outcome.status != StageStatus::kLeftOut)
    ++settled_count_;
  else if (graph_.tasks[task].left_out.empty())
    --stage_count_;  // counted before it was known
  running_.erase(task);
  switch (outcome.status) {
    case StageStatus::kRan:
      line(label(task) + "ran " + durationText(outcome.entry->run.wall_s) + inParentheses(outcome.reason));
      for (const Omission& omission : outcome.omissions) line(label(task) + "leaves out " + text(omission));
      break;
    case StageStatus::kCached:
      if (outcome.published) line(label(task) + "taken from the cache" + inParentheses(outcome.reason));
      break;
    case StageStatus::kFailed:
      error("bakelight: " + graph_.nameOf(task) + ": " + outcome.error->paragraph());
      break;
    case StageStatus::kNotRun:
      line(label(task) + "not run" + inParentheses(outcome.reason));
      break;
    case StageStatus::kLeftOut:
      tellLeftOut(task, outcome);
      break;
  }
  drawLive();
}

// What is not delivered is told each time, all else when it is new.
void Console::tellLeftOut(TaskIndex task, const Outcome& outcome) {
  const auto& deliverables = graph_.tasks[task].deliverables;
  const bool undelivered = !outcome.omissions.empty() && !deliverables.empty();
  if (!outcome.published && !undelivered) return;
  std::string text = "left out" + inParentheses(outcome.reason);
  const char* separator = "; not delivered: ";
  for (const auto& [port, name] : deliverables) {
    text += separator + name;
    separator = ", ";
  }
  line(label(task) + text);
}

void Console::summarize(const BuildResult& result, const OutputFolder& out) {
  clearLive();
  std::map<StageStatus, std::size_t> count;
  std::size_t restored = 0;
  for (const Outcome& outcome : result.outcomes) {
    ++count[outcome.status];
    if (outcome.status == StageStatus::kCached && outcome.published) ++restored;
  }
  for (const Error& unwritten : result.unwritten_records) error("bakelight: " + unwritten.paragraph());
  const std::size_t up_to_date = count[StageStatus::kCached] - restored;
  if (count[StageStatus::kRan] + restored + count[StageStatus::kFailed] + count[StageStatus::kNotRun] == 0)
    return line("everything is up to date (" + counted(graph_.assets.size(), "asset") + ", " +
                counted(up_to_date, "stage") + ")");

  std::vector<std::string> parts;
  const auto add = [&](std::size_t number, const char* text) {
    if (number > 0) parts.push_back(std::to_string(number) + " " + text);
  };
  add(count[StageStatus::kRan], "ran");
  add(restored, "from the cache");
  add(up_to_date, "up to date");
  add(count[StageStatus::kFailed], "failed");
  add(count[StageStatus::kNotRun], "not run");
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
  line((result.interrupted ? "interrupted: " : "") + formats::join(parts, ", ") + ", in " +
       durationText(elapsed.count()));

  std::vector<std::string> delivered;
  for (TaskIndex task = 0; task < graph_.tasks.size(); ++task)
    for (const auto& [port, name] : graph_.tasks[task].deliverables)
      if (result.outcomes[task].entry && graph_.tasks[task].published)
        delivered.push_back(out.pathOf(task, port).string());
  for (std::size_t i = 0; i < std::min(delivered.size(), kMaxListed); ++i) line("  " + delivered[i]);
  if (delivered.size() > kMaxListed) line("  and " + std::to_string(delivered.size() - kMaxListed) + " more");
}

void Console::line(const std::string& text) {
  clearLive();
  lines_ << text << std::endl;
}

void Console::error(const std::string& text) {
  clearLive();
  errors_ << text << std::endl;
}

void Console::clearLive() {
  if (!live_shown_) return;
  errors_ << kEraseLine << std::flush;
  live_shown_ = false;
  next_draw_ = {};
}

void Console::drawLive() {
  const auto now = std::chrono::steady_clock::now();
  if (!live_ || running_.empty() || now < next_draw_) return;
  next_draw_ = now + kRedraw;
  const auto shown = running_.count(latest_) != 0 ? running_.find(latest_) : running_.begin();
  errors_ << kEraseLine << '[' << settled_count_ + 1 << '/' << stage_count_ << "] "
          << graph_.nameOf(shown->first) << "  " << progressText(shown->second);
  if (running_.size() > 1) errors_ << "  and " << running_.size() - 1 << " more";
  errors_ << std::flush;
  live_shown_ = true;
}

}  // namespace bakelight::pipeline
