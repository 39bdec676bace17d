#include "pipeline/local_runner.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <system_error>

namespace bakelight::pipeline {
namespace {

using Clock = std::chrono::steady_clock;

// How long a tool may take to clean up after SIGTERM.
constexpr auto kGrace = std::chrono::seconds(3);
constexpr int kEndCheck_ms = 20;  // where the kernel does not wake us at the end of a process

volatile std::sig_atomic_t signals_seen = 0;
int wake_pipe[2] = {-1, -1};

void onSignal(int) {
  const int saved = errno;
  signals_seen = signals_seen + 1;
  const char byte = 0;
  [[maybe_unused]] const ssize_t written = ::write(wake_pipe[1], &byte, 1);
  errno = saved;
}

void handle(int signal, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  ::sigaction(signal, &action, nullptr);
}

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

[[noreturn]] void becomeTool(char* const* arguments, int output, int error_output, pid_t parent) {
  ::setpgid(0, 0);  // a Ctrl-C on the terminal reaches the driver alone, which then tells the tools
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(127);  // the driver died before the line above
  ::signal(SIGINT, SIG_DFL);
  ::signal(SIGTERM, SIG_DFL);
  ::signal(SIGPIPE, SIG_DFL);
  const int nothing = ::open("/dev/null", O_RDWR);
  ::dup2(nothing, STDIN_FILENO);
  ::dup2(output >= 0 ? output : nothing, STDOUT_FILENO);
  ::dup2(error_output >= 0 ? error_output : nothing, STDERR_FILENO);
  ::setenv("LC_ALL", "C", 1);
  ::execv(arguments[0], arguments);
  ::_exit(127);
}

struct Pipe {
  int read_end = -1, write_end = -1;
};

Pipe makePipe() {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  return {ends[0], ends[1]};
}

// Standard output goes to `output`, standard error to `error_output`; -1: nowhere.
pid_t spawn(const std::vector<std::string>& command, int output, int error_output) {
  if (::access(command.at(0).c_str(), X_OK) != 0)
    throw Error(ExitStatus::kNotAvailable, {command[0], "", ""},
                "cannot be run: " + std::generic_category().message(errno), "an executable");
  std::vector<char*> arguments;
  for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  const pid_t parent = ::getpid();
  const pid_t pid = ::fork();
  if (pid == 0) becomeTool(arguments.data(), output, error_output, parent);
  if (pid < 0)
    throw Error(ExitStatus::kNotAvailable, {command[0], "", ""},
                "cannot be started: " + std::generic_category().message(errno));
  ::setpgid(pid, pid);  // in both processes, as either may come first
  return pid;
}

// -1 where the kernel has no such call or forbids it.
int openProcess(pid_t pid) {
  return static_cast<int>(::syscall(SYS_pidfd_open, pid, 0));
}

pid_t waitFor(pid_t pid, int& status, rusage& usage) {
  pid_t waited;
  do waited = ::wait4(pid, &status, 0, &usage);
  while (waited < 0 && errno == EINTR);
  return waited;
}

}  // namespace

LocalRunner::LocalRunner(bool process_descriptors) : process_descriptors_(process_descriptors) {
  signals_seen = 0;
  const Pipe wake = makePipe();
  wake_pipe[0] = wake.read_end;
  wake_pipe[1] = wake.write_end;
  ::fcntl(wake_pipe[1], F_SETFL, O_NONBLOCK);
  handle(SIGINT, onSignal);
  handle(SIGTERM, onSignal);
}

LocalRunner::~LocalRunner() {
  killAll(SIGKILL);
  while (!children_.empty()) reap(children_.begin()->first);
  handle(SIGINT, SIG_DFL);
  handle(SIGTERM, SIG_DFL);
  ::close(wake_pipe[0]);
  ::close(wake_pipe[1]);
}

void LocalRunner::start(Job job, const std::vector<std::string>& command) {
  const Pipe lines = makePipe();
  Child child;
  child.start = Clock::now();
  try {
    child.pid = spawn(command, lines.write_end, lines.write_end);
  } catch (...) {
    ::close(lines.read_end);
    ::close(lines.write_end);
    throw;
  }
  ::close(lines.write_end);
  ::fcntl(lines.read_end, F_SETFL, O_NONBLOCK);
  child.error_descriptor = lines.read_end;
  if (process_descriptors_) child.exit_descriptor = openProcess(child.pid);
  children_[job] = std::move(child);
}

bool LocalRunner::interrupted() const {
  return signals_seen > 0;
}

std::optional<Event> LocalRunner::wait(int timeout_ms) {
  if (events_.empty()) {
    std::vector<pollfd> watched = {{wake_pipe[0], POLLIN, 0}};
    std::vector<Job> jobs;
    for (const auto& [job, child] : children_) {
      if (child.exit_descriptor < 0)
        timeout_ms = timeout_ms < 0 ? kEndCheck_ms : std::min(timeout_ms, kEndCheck_ms);
      jobs.push_back(job);
      watched.push_back({child.exit_descriptor, POLLIN, 0});
      watched.push_back({child.error_descriptor, POLLIN, 0});
    }
    ::poll(watched.data(), watched.size(), timeout_ms);
    for (std::size_t i = 0; i < jobs.size(); ++i) {
      if (watched[2 + 2 * i].revents != 0) readLines(jobs[i], children_.at(jobs[i]));
      if (watched[1 + 2 * i].revents != 0 || hasEnded(children_.at(jobs[i]))) reap(jobs[i]);
    }
    if (kill_at_ && Clock::now() >= *kill_at_) killAll(SIGKILL);
    if (signals_seen > signals_reported_) {
      std::array<char, 64> drained;
      [[maybe_unused]] const ssize_t got = ::read(wake_pipe[0], drained.data(), drained.size());
      // Whoever asks twice does not want to wait for a clean end.
      if (signals_reported_ > 0) killAll(SIGKILL);
      signals_reported_ = signals_seen;
      events_.push_back({0, Interrupted{}});
    }
  }
  if (events_.empty()) return std::nullopt;
  Event event = std::move(events_.front());
  events_.pop_front();
  return event;
}

// For children without a descriptor that tells. Leaves the status for reap.
bool LocalRunner::hasEnded(const Child& child) {
  if (child.exit_descriptor >= 0) return false;
  siginfo_t ended{};
  return ::waitid(P_PID, static_cast<id_t>(child.pid), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
         ended.si_pid == child.pid;
}

void LocalRunner::readLines(Job job, Child& child) {
  std::array<char, 4096> block;
  while (true) {
    const ssize_t got = ::read(child.error_descriptor, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return;
    if (got == 0) {  // closed: poll ignores negative descriptors
      ::close(child.error_descriptor);
      child.error_descriptor = -1;
      return;
    }
    child.unfinished_line.append(block.data(), static_cast<std::size_t>(got));
    std::size_t begin = 0, end;
    while ((end = child.unfinished_line.find('\n', begin)) != std::string::npos) {
      takeLine(job, child, std::string_view(child.unfinished_line).substr(begin, end - begin));
      begin = end + 1;
    }
    child.unfinished_line.erase(0, begin);
  }
}

void LocalRunner::takeLine(Job job, Child& child, std::string_view line) {
  auto parsed = parseToolLine(line);
  if (auto* error = std::get_if<Error>(&parsed)) child.error = std::move(*error);
  if (auto* progress = std::get_if<ToolProgress>(&parsed)) events_.push_back({job, std::move(*progress)});
  if (auto* warning = std::get_if<ToolWarning>(&parsed)) events_.push_back({job, std::move(*warning)});
  if (auto* text = std::get_if<ToolText>(&parsed)) events_.push_back({job, std::move(*text)});
}

void LocalRunner::reap(Job job) {
  Child& child = children_.at(job);
  int status = 0;
  rusage usage{};
  waitFor(child.pid, status, usage);
  const std::chrono::duration<double> wall = Clock::now() - child.start;
  if (child.error_descriptor >= 0) readLines(job, child);
  if (!child.unfinished_line.empty()) takeLine(job, child, child.unfinished_line);
  if (child.error_descriptor >= 0) ::close(child.error_descriptor);
  if (child.exit_descriptor >= 0) ::close(child.exit_descriptor);
  events_.push_back(
      {job, ToolFinished{.exit_status = WIFEXITED(status) ? WEXITSTATUS(status) : 0,
                         .signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0,
                         .wall_s = wall.count(),
                         .cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime),
                         .peak_memory_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024,
                         .error = std::move(child.error)}});
  children_.erase(job);
}

void LocalRunner::stopAll() {
  killAll(SIGTERM);
  kill_at_ = Clock::now() + kGrace;
}

void LocalRunner::killAll(int signal) {
  for (const auto& [job, child] : children_) ::kill(-child.pid, signal);
}

Captured LocalRunner::capture(const std::vector<std::string>& command) {
  const Pipe output = makePipe();
  pid_t pid;
  try {
    pid = spawn(command, output.write_end, -1);
  } catch (...) {
    ::close(output.read_end);
    ::close(output.write_end);
    throw;
  }
  ::close(output.write_end);
  Captured captured;
  std::array<char, 4096> block;
  while (true) {
    const ssize_t got = ::read(output.read_end, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    captured.output.append(block.data(), static_cast<std::size_t>(got));
  }
  ::close(output.read_end);
  int status = 0;
  rusage usage{};
  waitFor(pid, status, usage);
  captured.exit_status = WIFEXITED(status) ? WEXITSTATUS(status) : 0;
  captured.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  return captured;
}

}  // namespace bakelight::pipeline
