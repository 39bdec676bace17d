#include "fakes.h"

#include <algorithm>

#include "formats/error.h"
#include "formats/hash.h"
#include "formats/tool_description.h"

namespace bakelight::pipeline {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

std::string nameOf(const Disk::Path& path) {
  std::string name = path.lexically_normal().string();
  if (name.size() > 1 && name.back() == '/') name.pop_back();
  return name;
}

bool isInside(const std::string& name, const std::string& folder) {
  return name.starts_with(folder + "/");
}

}  // namespace

std::optional<FileStat> FakeDisk::stat(const Path& path) const {
  const std::string name = nameOf(path);
  const auto file = files_.find(name);
  if (file != files_.end())
    return FileStat{false, file->second.content.size(), file->second.mtime_ns, file->second.inode};
  const auto within = files_.lower_bound(name + "/");
  const bool is_folder =
      folders_.count(name) != 0 || (within != files_.end() && isInside(within->first, name));
  return is_folder ? std::optional(FileStat{.folder = true}) : std::nullopt;
}

std::vector<std::string> FakeDisk::list(const Path& folder) const {
  std::set<std::string> names;
  const std::string prefix = nameOf(folder) + "/";
  const auto add = [&](const std::string& name) {
    names.insert(name.substr(prefix.size(), name.find('/', prefix.size()) - prefix.size()));
  };
  for (auto file = files_.lower_bound(prefix); file != files_.end() && file->first.starts_with(prefix);
       ++file)
    add(file->first);
  for (auto name = folders_.lower_bound(prefix); name != folders_.end() && name->starts_with(prefix); ++name)
    add(*name);
  return {names.begin(), names.end()};
}

std::string FakeDisk::read(const Path& path) const {
  ++reads;
  const auto file = files_.find(nameOf(path));
  if (file == files_.end()) throw badInput({path.string(), "", ""}, "does not exist");
  return file->second.content;
}

std::string FakeDisk::hash(const Path& path) const {
  ++hashes;
  const auto file = files_.find(nameOf(path));
  if (file == files_.end()) throw badInput({path.string(), "", ""}, "does not exist");
  return formats::contentHash(file->second.content);
}

std::int64_t FakeDisk::now_ns() const {
  return clock_ns_ + kSecond_ns;
}

void FakeDisk::makeFolders(const Path& folder) {
  folders_.insert(nameOf(folder));
}

void FakeDisk::put(const Path& path, std::string content) {
  if (!full.empty() && path.string().find(full) != std::string::npos)
    throw cannotWrite(path.string(), "writing failed: No space left on device");
  clock_ns_ += kSecond_ns;
  ++writes;
  files_[nameOf(path)] = {std::move(content), clock_ns_, ++last_inode_};
}

void FakeDisk::write(const Path& path, std::string_view text) {
  put(path, std::string(text));
}

void FakeDisk::copy(const Path& from, const Path& to) {
  put(to, files_.at(nameOf(from)).content);
}

void FakeDisk::rename(const Path& from, const Path& to) {
  const std::string old_name = nameOf(from), new_name = nameOf(to);
  std::vector<std::string> names;
  for (auto file = files_.lower_bound(old_name); file != files_.end() && file->first.starts_with(old_name);
       ++file)
    if (file->first == old_name || isInside(file->first, old_name)) names.push_back(file->first);
  for (const std::string& name : names) {
    auto file = files_.extract(name);
    file.key() = new_name + name.substr(old_name.size());
    files_.insert(std::move(file));
  }
  folders_.erase(old_name);
}

void FakeDisk::removeAll(const Path& path) {
  const std::string gone = nameOf(path);
  std::erase_if(files_,
                [&](const auto& entry) { return entry.first == gone || isInside(entry.first, gone); });
  std::erase_if(folders_, [&](const auto& name) { return name == gone || isInside(name, gone); });
}

void FakeDisk::touch(const Path& path) {
  files_.at(nameOf(path)).mtime_ns = clock_ns_ += kSecond_ns;
}

std::vector<std::string> FakeDisk::paths() const {
  return pathsContaining("");
}

std::vector<std::string> FakeDisk::pathsContaining(const std::string& text) const {
  std::vector<std::string> found;
  for (const auto& [name, file] : files_)
    if (name.find(text) != std::string::npos) found.push_back(name);
  return found;
}

void FakeRunner::install(const std::string& name, FakeTool tool, const std::string& revision) {
  disk_.write("tools/" + name, revision);
  tools_[name] = std::move(tool);
}

Captured FakeRunner::capture(const std::vector<std::string>& command) {
  ++descriptions;
  return {.output = tools_.at(Disk::Path(command[0]).filename().string()).description.dump()};
}

void FakeRunner::start(Job job, const std::vector<std::string>& command) {
  commands.push_back(command);
  running_.push_back({job, command});
  most_at_once = std::max(most_at_once, running_.size());
  int threads = 0;
  for (const Started& started : running_) threads += std::stoi(valueOf(started.command, "--threads"));
  most_threads_at_once = std::max(most_threads_at_once, threads);
  if (interrupt_after && commands.size() >= *interrupt_after) interrupted_ = true;
}

std::optional<Event> FakeRunner::wait(int) {
  if (interrupted_ && !interruption_told_) {
    interruption_told_ = true;
    return Event{0, Interrupted{}};
  }
  if (running_.empty()) return std::nullopt;
  const Started next = last_started_ends_first ? running_.back() : running_.front();
  last_started_ends_first ? running_.pop_back() : running_.pop_front();
  return Event{next.job, interrupted_ ? ToolFinished{.exit_status = 130} : work(next.command)};
}

void FakeRunner::stopAll() {
  interrupted_ = true;
}

ToolFinished FakeRunner::work(const std::vector<std::string>& command) {
  const std::string name = Disk::Path(command[0]).filename().string();
  if (killed_by.count(name) != 0) return {.signal = killed_by[name]};
  const FakeTool& tool = tools_.at(name);
  const auto description = formats::toolDescriptionFromJson(tool.description, name);
  const auto option = [](const std::string& port) { return "--" + port; };
  try {
    std::map<std::string, std::string> inputs;
    for (const auto& port : description.inputs)
      if (const std::string path = valueOf(command, option(port.name)); !path.empty())
        inputs[port.name] = disk_.read(path);
    const auto parameters = nlohmann::json::parse(disk_.read(valueOf(command, "--parameters")));
    for (const auto& [port, content] : tool.make(inputs, parameters))
      disk_.write(valueOf(command, option(port)), content);
  } catch (const Error& error) {
    return {.exit_status = static_cast<int>(error.status()), .error = error};
  }
  nlohmann::json stats = {{"tool", name},
                          {"wall_s", 0.0},
                          {"cpu_s", 0.0},
                          {"peak_memory_bytes", 0},
                          {"warnings", nlohmann::json::array()},
                          {"stats", tool.stats}};
  stats["stats"]["inputs"] = description.inputs.size();
  disk_.write(valueOf(command, "--stats"), stats.dump());
  return {.wall_s = 1.5, .cpu_s = 2.5, .peak_memory_bytes = 4096};
}

void FakeRunner::forgetInterruption() {
  interrupted_ = interruption_told_ = false;
  interrupt_after.reset();
}

std::vector<std::string> FakeRunner::toolsStarted() const {
  std::vector<std::string> names;
  for (const auto& command : commands) names.push_back(Disk::Path(command[0]).filename().string());
  return names;
}

std::string valueOf(const std::vector<std::string>& command, const std::string& option) {
  const auto found = std::find(command.begin(), command.end(), option);
  return found == command.end() || found + 1 == command.end() ? "" : *(found + 1);
}

}  // namespace bakelight::pipeline
