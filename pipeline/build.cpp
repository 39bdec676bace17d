#include "pipeline/build.h"

#include <signal.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <utility>

#include "formats/error.h"
#include "formats/words.h"
#include "pipeline/companions.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;
namespace {

constexpr int kWait_ms = 100;
constexpr int kSignalBase = 128;  // a shell's convention for the status of a killed process
constexpr const char* kParametersFile = "parameters.json";
constexpr const char* kInterrupted = "interrupted";

std::string optionFor(const std::string& port) {
  std::string option = "--" + port;
  std::replace(option.begin() + 2, option.end(), '_', '-');
  return option;
}

// Of an input that is no file of the asset.
std::string fileFor(const std::string& port) {
  return port + ".json";
}

void replaceAll(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

std::string signalName(int signal) {
  const char* abbreviation = ::sigabbrev_np(signal);
  return abbreviation != nullptr ? std::string("SIG") + abbreviation : "signal " + std::to_string(signal);
}

}  // namespace

int BuildResult::exitStatus() const {
  if (interrupted) return static_cast<int>(ExitStatus::kInterrupted);
  for (const Outcome& outcome : outcomes)
    if (outcome.status == StageStatus::kFailed) return outcome.exit_status;
  return unwritten_records.empty() ? 0 : static_cast<int>(unwritten_records.front().status());
}

Build::Build(const Parts& parts, const std::vector<PastRecord>& past, BuildSettings settings)
    : parts_(parts),
      graph_(parts.graph),
      past_(past),
      settings_(settings),
      explainer_(parts.graph, parts.tools, parts.cache, parts.out, parts.disk, parts.memo, past),
      demand_(parts.graph),
      free_cores_(settings.cores) {}

BuildResult Build::run() {
  prepare();
  while (true) {
    if (!result_.interrupted && parts_.runner.interrupted()) interrupt();
    startWhatIsReady();
    if (running_.empty() && ready_.empty()) break;
    if (const auto event = parts_.runner.wait(kWait_ms)) take(*event);
  }
  for (TaskIndex task = 0; task < graph_.tasks.size(); ++task)
    if (!settled_[task]) settleNotRun(task, kInterrupted);
  return std::move(result_);
}

void Build::prepare() {
  const std::size_t count = graph_.tasks.size();
  result_.outcomes.resize(count);
  entries_.resize(count);
  settled_.resize(count);
  open_stages_.resize(graph_.assets.size());
  for (TaskIndex task = 0; task < count; ++task) ++open_stages_[graph_.tasks[task].asset];
  for (TaskIndex task = 0; task < count; ++task) {
    if (!graph_.tasks[task].left_out.empty())
      settle(task, {.status = StageStatus::kLeftOut, .reason = graph_.tasks[task].left_out});
    else
      advance(task);
  }
}

void Build::startWhatIsReady() {
  while (!result_.interrupted && !ready_.empty() && running_.size() < settings_.jobs && free_cores_ > 0) {
    const TaskIndex task = *ready_.begin();
    ready_.erase(ready_.begin());
    try {
      consider(task);
    } catch (const Error& error) {
      settleFailed(task, error, static_cast<int>(error.status()));
    }
    if (parts_.runner.interrupted()) interrupt();
  }
}

void Build::consider(TaskIndex task) {
  if (demand_.undecided(task)) return decide(task);
  Verdict verdict = explainer_.judge(task, entries_);
  if (verdict.mustRun()) return launch(task, std::move(verdict));

  parts_.out.publish(task, *verdict.entry);
  std::string reason = "up to date";
  if (!verdict.changes.empty())
    reason = formats::join(verdict.changes, "; ");
  else if (!verdict.misplaced.empty())
    reason = formats::join(verdict.misplaced, "; ");
  settle(task, {.status = StageStatus::kCached,
                .reason = std::move(reason),
                .published = !verdict.upToDate(),
                .ingredients = std::move(verdict.ingredients),
                .omissions = std::move(verdict.omissions),
                .entry = std::move(verdict.entry)});
}

// Once its rules can be judged, whether it is made at all.
void Build::decide(TaskIndex task) {
  if (const auto omission = omissionOf(graph_, task, entries_))
    return settleLeftOut(task, text(*omission), {*omission});
  for (const TaskIndex asked : demand_.keep(task)) advance(asked);
  advance(task);
}

void Build::launch(TaskIndex task, Verdict verdict) {
  Running running{.key = verdict.ingredients.key(),
                  .ingredients = std::move(verdict.ingredients),
                  .omissions = std::move(verdict.omissions),
                  .reason = formats::join(verdict.changes, "; "),
                  .threads = threadsForNext()};
  const auto same = std::find_if(running_.begin(), running_.end(),
                                 [&](const auto& other) { return other.second.key == running.key; });
  if (same != running_.end()) {
    same_key_[running.key].push_back(task);
    return;
  }
  running.folder = parts_.cache.startEntry(running.key);
  try {
    parts_.disk.write(running.folder / kParametersFile, running.ingredients.parameters.dump(2) + "\n");
    for (const auto& [port, input] : graph_.tasks[task].inputs)
      if (!input.value.is_null())
        parts_.disk.write(running.folder / fileFor(port), withAbsolutePaths(input.value).dump(2) + "\n");
    parts_.runner.start(task, commandFor(task, running));
  } catch (...) {
    parts_.cache.dropEntry(running.key);
    throw;
  }
  free_cores_ -= running.threads;
  running_.emplace(task, std::move(running));
  parts_.observer.started(task);
}

// The free cores, shared evenly among what can start now; outputs do not depend on it.
std::size_t Build::threadsForNext() const {
  const std::size_t starting = std::min(settings_.jobs - running_.size(), ready_.size() + 1);
  return std::max<std::size_t>(1, free_cores_ / starting);
}

std::vector<std::string> Build::commandFor(TaskIndex index, const Running& running) const {
  const Task& task = graph_.tasks[index];
  std::vector<std::string> command = {parts_.tools.require(task.tool, {}).executable.string()};
  const auto add = [&](const std::string& option, const std::string& value) {
    command.push_back(option);
    command.push_back(value);
  };
  for (const auto& [port, input] : task.inputs) {
    if (input.maker && !entries_[*input.maker]) continue;  // omitted
    const auto made = [&, input = input] {
      return entries_[*input.maker]->pathOf(entries_[*input.maker]->outputs.at(input.port));
    };
    add(optionFor(port), (input.maker              ? made()
                          : !input.value.is_null() ? running.folder / fileFor(port)
                                                   : input.file)
                             .string());
  }
  for (const auto& [port, file] : task.outputs) add(optionFor(port), (running.folder / file).string());
  add("--parameters", (running.folder / kParametersFile).string());
  add("--threads", std::to_string(running.threads));
  add("--stats", (running.folder / kStatsFile).string());
  add("--progress", "json");
  return command;
}

void Build::take(const Event& event) {
  if (std::holds_alternative<Interrupted>(event.what)) return interrupt();
  const TaskIndex task = event.job;
  if (const auto* progress = std::get_if<ToolProgress>(&event.what))
    parts_.observer.progressed(task, *progress);
  if (const auto* warning = std::get_if<ToolWarning>(&event.what))
    parts_.observer.said(task, "warning: " + withPublicPaths(task, running_.at(task), warning->text));
  if (const auto* text = std::get_if<ToolText>(&event.what))
    parts_.observer.said(task, withPublicPaths(task, running_.at(task), text->line));
  if (const auto* finished = std::get_if<ToolFinished>(&event.what)) finish(task, *finished);
}

void Build::finish(TaskIndex task, const ToolFinished& finished) {
  const auto node = running_.extract(task);
  const Running& running = node.mapped();
  free_cores_ += running.threads;
  try {
    const bool done = finished.exit_status == 0 && finished.signal == 0;
    if (done) accept(task, running, finished);
    if (!done) parts_.cache.dropEntry(running.key);
    if (!done && result_.interrupted) settleNotRun(task, kInterrupted);
    if (!done && !result_.interrupted)
      settleFailed(task, failureOf(task, running, finished),
                   finished.signal != 0 ? kSignalBase + finished.signal : finished.exit_status);
  } catch (const Error& error) {
    settleFailed(task, error, static_cast<int>(error.status()));
  }
  // Those that waited for the same entry find it now, or meet the same failure themselves.
  const auto waiting = same_key_.extract(running.key);
  if (!waiting.empty() && !result_.interrupted)
    ready_.insert(waiting.mapped().begin(), waiting.mapped().end());
}

void Build::accept(TaskIndex task, const Running& running, const ToolFinished& finished) {
  Outcome outcome{.status = StageStatus::kRan,
                  .reason = running.reason,
                  .published = true,
                  .ingredients = running.ingredients,
                  .omissions = running.omissions};
  try {
    outcome.entry = parts_.cache.finishEntry(running.key, running.ingredients,
                                             {.tool = "",
                                              .wall_s = finished.wall_s,
                                              .cpu_s = finished.cpu_s,
                                              .peak_memory_bytes = finished.peak_memory_bytes,
                                              .warnings = {}});
  } catch (...) {
    parts_.cache.dropEntry(running.key);
    throw;
  }
  parts_.out.publish(task, *outcome.entry);
  settle(task, std::move(outcome));
}

Error Build::failureOf(TaskIndex task, const Running& running, const ToolFinished& finished) const {
  const std::string& tool = graph_.tasks[task].tool;
  if (finished.signal == SIGKILL)
    return badInput({}, "the tool " + tool + " was killed by SIGKILL", "",
                    "look whether memory ran out; if not, report this as a bug of the tool");
  if (finished.signal != 0)
    return badInput({}, "the tool " + tool + " was killed by " + signalName(finished.signal), "",
                    "report this as a bug of the tool, with the input and " +
                        parts_.out.recordOf(graph_.tasks[task].asset).string());
  if (!finished.error)
    return badInput({}, "the tool " + tool + " ended with exit status " +
                            std::to_string(finished.exit_status) + " and said no more");
  const Error& told = *finished.error;
  const auto mapped = [&](const std::string& text) { return withPublicPaths(task, running, text); };
  return {told.status(),
          {mapped(told.place().file), told.place().element, told.place().pointer},
          mapped(told.problem()),
          mapped(told.expected()),
          mapped(told.remedy())};
}

void Build::interrupt() {
  if (result_.interrupted) return;
  result_.interrupted = true;
  ready_.clear();
  parts_.runner.stopAll();
}

void Build::settle(TaskIndex task, Outcome outcome) {
  entries_[task] = outcome.entry;
  result_.outcomes[task] = std::move(outcome);
  settled_[task] = true;
  parts_.observer.settled(task, result_.outcomes[task]);
  if (!entries_[task])
    for (const TaskIndex unneeded : demand_.close(task)) settleUnneeded(unneeded);
  for (const TaskIndex user : demand_.usersOf(task)) advance(user);
  const std::size_t asset = graph_.tasks[task].asset;
  if (--open_stages_[asset] == 0) writeRecord(asset);
}

void Build::settleFailed(TaskIndex task, const Error& error, int exit_status) {
  settle(task, {.status = StageStatus::kFailed,
                .reason = error.problem(),
                .error = error,
                .exit_status = exit_status});
}

void Build::settleNotRun(TaskIndex task, const std::string& reason) {
  if (!settled_[task]) settle(task, {.status = StageStatus::kNotRun, .reason = reason});
}

// By measurement: nothing of it stays in the output folder.
void Build::settleLeftOut(TaskIndex task, const std::string& reason, std::vector<Omission> omissions) {
  const bool is_new = explainer_.newlyLeftOut(task, reason);
  try {
    if (is_new) parts_.out.withdraw(task);
  } catch (const Error& error) {
    return settleFailed(task, error, static_cast<int>(error.status()));
  }
  settle(task, {.status = StageStatus::kLeftOut,
                .reason = reason,
                .published = is_new,
                .omissions = std::move(omissions)});
}

// Nothing will ask for it any more: what would have is omitted, or was not run itself.
void Build::settleUnneeded(TaskIndex task) {
  for (const TaskIndex user : demand_.usersOf(task))
    if (const auto reason = reasonNotToRunAfter(user)) return settleNotRun(task, *reason);
  settleLeftOut(task, demand_.onlyFor(task), {});
}

// Why what needs `maker` cannot be run; nothing if it can, or if it is not known yet.
std::optional<std::string> Build::reasonNotToRunAfter(TaskIndex maker) const {
  if (!settled_[maker]) return {};
  const Outcome& outcome = result_.outcomes[maker];
  if (outcome.status == StageStatus::kFailed) return graph_.tasks[maker].stage + " failed";
  if (outcome.status == StageStatus::kNotRun) return outcome.reason;
  return {};
}

// By what became of what it waits for, the task is ready, or given up.
void Build::advance(TaskIndex task) {
  if (settled_[task] || !demand_.asked(task)) return;
  bool ready = !result_.interrupted;
  for (const TaskIndex maker : demand_.awaitedBy(task)) {
    if (const auto reason = reasonNotToRunAfter(maker)) return settleNotRun(task, *reason);
    ready = ready && settled_[maker];
  }
  if (ready) ready_.insert(task);
}

void Build::writeRecord(std::size_t asset) {
  try {
    const formats::Json record = recordOf(graph_, asset, result_.outcomes, parts_.out, past_[asset]);
    const std::string text = record.dump(2, ' ', false, formats::Json::error_handler_t::replace) + "\n";
    if (text != past_[asset].text()) parts_.disk.write(parts_.out.recordOf(asset), text);
  } catch (const Error& error) {
    result_.unwritten_records.push_back(error);
  }
}

// A tool speaks of files in the cache; the user knows them by their names in the output folder.
std::string Build::withPublicPaths(TaskIndex index, const Running& running, std::string text) const {
  const Task& task = graph_.tasks[index];
  for (const auto& [port, file] : task.outputs)
    replaceAll(text, (running.folder / file).string(), parts_.out.pathOf(index, port).string());
  for (const auto& [port, input] : task.inputs) {
    if (!input.value.is_null())
      replaceAll(text, (running.folder / fileFor(port)).string(), input.file.string());
    if (!input.maker || !entries_[*input.maker]) continue;
    const CacheEntry& entry = *entries_[*input.maker];
    replaceAll(text, entry.pathOf(entry.outputs.at(input.port)).string(),
               parts_.out.pathOf(*input.maker, input.port).string());
  }
  return text;
}

}  // namespace bakelight::pipeline
