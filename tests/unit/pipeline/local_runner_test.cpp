#include "pipeline/local_runner.h"

#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <map>

namespace bakelight::pipeline {
namespace {

constexpr unsigned kPatience_s = 20;

// Runs so many tools at once and returns how each ended; none if one never does.
std::map<Job, ToolFinished> runAll(const std::vector<std::vector<std::string>>& commands) {
  LocalRunner runner;
  for (Job job = 0; job < commands.size(); ++job) runner.start(job, commands[job]);
  std::map<Job, ToolFinished> ends;
  ::alarm(kPatience_s);
  while (ends.size() < commands.size())
    if (auto event = runner.wait(-1))
      if (auto* finished = std::get_if<ToolFinished>(&event->what)) ends[event->job] = *finished;
  ::alarm(0);
  return ends;
}

// What a container of an older seccomp profile, or a kernel before 5.3, answers to pidfd_open.
void denyProcessDescriptors() {
  std::array filter = {
      sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_pidfd_open, 0, 1),
      sock_filter BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | ENOSYS),
      sock_filter BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog program{static_cast<unsigned short>(filter.size()), filter.data()};
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  ASSERT_EQ(::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program), 0);
  ASSERT_LT(::syscall(SYS_pidfd_open, ::getpid(), 0), 0);
}

TEST(LocalRunner, EveryToolsEndIsTold) {
  std::vector<std::vector<std::string>> commands;
  for (int status = 0; status < 40; ++status)
    commands.push_back({"/bin/sh", "-c", "exit " + std::to_string(status)});
  commands.push_back({"/bin/sh", "-c", "kill -9 $$"});
  // One that closes its output long before it ends.
  commands.push_back({"/bin/sh", "-c", "exec >&- 2>&-; sleep 0.2; exit 7"});
  auto ends = runAll(commands);
  for (int status = 0; status < 40; ++status) EXPECT_EQ(ends[status].exit_status, status);
  EXPECT_EQ(ends[40].signal, SIGKILL);
  EXPECT_EQ(ends[41].exit_status, 7);
}

TEST(LocalRunner, WaitsForNobodyWhereThereAreNoProcessDescriptors) {
  const auto run = [] {
    denyProcessDescriptors();
    const auto ends = runAll({{"/bin/sh", "-c", "sleep 0.1; exit 3"}});
    ::_exit(ends.at(0).exit_status);
  };
  EXPECT_EXIT(run(), testing::ExitedWithCode(3), "");
}

TEST(LocalRunner, HearsOfEndsThoughSigchldWasBlocked) {
  const auto run = [] {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGCHLD);
    ::sigprocmask(SIG_BLOCK, &set, nullptr);
    ::_exit(runAll({{"/bin/sh", "-c", "sleep 0.1; exit 4"}}).at(0).exit_status);
  };
  EXPECT_EXIT(run(), testing::ExitedWithCode(4), "");
}

}  // namespace
}  // namespace bakelight::pipeline
