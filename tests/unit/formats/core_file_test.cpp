#include "formats/file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "formats/error.h"
#include "tests/support/temporary_folder.h"

namespace bakelight::formats {
namespace {

using tests::TemporaryFolder;

TEST(File, ComesBackAsWritten) {
  const TemporaryFolder folder;
  std::string text = "line\n";
  text.push_back('\0');
  text += "after a zero byte";
  writeFileAtomically(folder / "deep/er/file.bin", text);
  EXPECT_EQ(readTextFile(folder / "deep/er/file.bin"), text);
  writeFileAtomically(folder / "deep/er/file.bin", "");
  EXPECT_EQ(readTextFile(folder / "deep/er/file.bin"), "");
}

TEST(File, WholeFileIsHeldOnce) {
  const TemporaryFolder folder;
  writeFileAtomically(folder / "file", std::string(300'000, 'x'));
  const Bytes bytes = readFile(folder / "file");
  EXPECT_EQ(bytes.size(), 300'000U);
  EXPECT_EQ(bytes.capacity(), bytes.size());
}

TEST(File, FilesThatStateNoSizeComeWhole) {
  EXPECT_THAT(readTextFile("/proc/self/status"), testing::HasSubstr("VmPeak"));
  EXPECT_TRUE(readFile("/dev/null").empty());
}

TEST(File, MissingFileAndFolderAreNamed) {
  const TemporaryFolder folder;
  for (const std::string name : {"absent.ply", "."}) {
    try {
      readFile(folder / name);
      FAIL() << "no error for " << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), ExitStatus::kBadInput);
      EXPECT_EQ(error.place().file, (folder / name).string());
    }
  }
}

// A file-size limit makes write() fail like a full disk does (EFBIG for ENOSPC). In a child, as the limit
// stays.
TEST(File, FailedWriteKeepsTheOldContentAndLeavesNothingBehind) {
  const TemporaryFolder folder;
  writeFileAtomically(folder / "file", "old");
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1000, 1000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    int status = 0;
    try {
      writeFileAtomically(folder / "file", std::string(100000, 'x'));
    } catch (const Error& error) {
      status = static_cast<int>(error.status());
    }
    ::_exit(status);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), static_cast<int>(ExitStatus::kCannotWrite));
  EXPECT_EQ(readTextFile(folder / "file"), "old");
  EXPECT_EQ(folder.entryCount(), 1u);
}

TEST(File, UnwritableFolderIsAnError) {
  EXPECT_THROW(writeFileAtomically("/proc/no/such/place", "text"), Error);
}

}  // namespace
}  // namespace bakelight::formats
