#include "pipeline/disk.h"

#include <fcntl.h>
#include <linux/fs.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/hash.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;
namespace {

constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

std::int64_t nanoseconds(const timespec& time) {
  return static_cast<std::int64_t>(time.tv_sec) * kNanosecondsPerSecond + time.tv_nsec;
}

std::string messageOf(int error_number) {
  return std::system_category().message(error_number);
}

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return number_; }

 private:
  int number_;
};

// Fills `to` with the content of `from`: sharing blocks first, then inside the kernel, then by hand, as each
// of the faster ways is refused by some file systems. Returns 0 or an errno.
int copyContent(int from, int to) {
  if (::ioctl(to, FICLONE, from) == 0) return 0;
  while (true) {
    const ssize_t copied = ::copy_file_range(from, nullptr, to, nullptr, std::size_t{1} << 30, 0);
    if (copied == 0) return 0;
    if (copied < 0 && errno == EINTR) continue;
    if (copied < 0 && (errno == EXDEV || errno == EINVAL || errno == ENOSYS || errno == EOPNOTSUPP)) break;
    if (copied < 0) return errno;
  }
  std::vector<char> block(1 << 20);
  while (true) {
    const ssize_t got = ::read(from, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return errno;
    if (got == 0) return 0;
    for (ssize_t done = 0; done < got;) {
      const ssize_t written = ::write(to, block.data() + done, static_cast<std::size_t>(got - done));
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return errno;
      done += written;
    }
  }
}

void makeParent(const fs::path& path) {
  std::error_code failed;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), failed);
  if (failed) throw cannotWrite(path.string(), "its folder cannot be made: " + failed.message());
}

}  // namespace

bool Disk::isFile(const Path& path) const {
  const auto found = stat(path);
  return found && !found->folder;
}

bool Disk::isFolder(const Path& path) const {
  const auto found = stat(path);
  return found && found->folder;
}

std::optional<FileStat> RealDisk::stat(const Path& path) const {
  struct ::stat status {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  return FileStat{.folder = S_ISDIR(status.st_mode),
                  .bytes = static_cast<std::uint64_t>(status.st_size),
                  .mtime_ns = nanoseconds(status.st_mtim),
                  .inode = status.st_ino};
}

std::vector<std::string> RealDisk::list(const Path& folder) const {
  std::vector<std::string> names;
  std::error_code failed;
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed))
    names.push_back(entry->path().filename().string());
  if (failed) throw badInput({folder.string(), "", ""}, "cannot be listed: " + failed.message());
  std::sort(names.begin(), names.end());
  return names;
}

std::string RealDisk::read(const Path& path) const {
  return formats::readTextFile(path);
}

std::string RealDisk::hash(const Path& path) const {
  return formats::contentHashOfFile(path);
}

std::int64_t RealDisk::now_ns() const {
  timespec time{};
  ::clock_gettime(CLOCK_REALTIME, &time);
  return nanoseconds(time);
}

void RealDisk::makeFolders(const Path& folder) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) throw cannotWrite(folder.string(), "cannot be made: " + failed.message());
}

void RealDisk::write(const Path& path, std::string_view text) {
  formats::writeFileAtomically(path, text);
}

void RealDisk::copy(const Path& from, const Path& to) {
  makeParent(to);
  Path temporary = to;
  temporary += ".tmp-" + std::to_string(::getpid());
  const Descriptor source(::open(from.c_str(), O_RDONLY | O_CLOEXEC));
  if (source.get() < 0) throw badInput({from.string(), "", ""}, "cannot be opened: " + messageOf(errno));
  const Descriptor target(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  int error = target.get() < 0 ? errno : copyContent(source.get(), target.get());
  // Without the sync a crash soon after the rename can leave an empty file under the final name.
  if (error == 0 && ::fsync(target.get()) != 0) error = errno;
  if (error == 0 && ::rename(temporary.c_str(), to.c_str()) != 0) error = errno;
  if (error == 0) return formats::syncFolderOf(to);
  ::unlink(temporary.c_str());
  throw cannotWrite(to.string(), "copying failed: " + messageOf(error));
}

void RealDisk::rename(const Path& from, const Path& to) {
  makeParent(to);
  std::error_code failed;
  fs::rename(from, to, failed);
  if (failed) throw cannotWrite(to.string(), "cannot be put in place: " + failed.message());
  formats::syncFolderOf(to);
}

void RealDisk::removeAll(const Path& path) {
  std::error_code failed;
  fs::remove_all(path, failed);
  if (failed) throw cannotWrite(path.string(), "cannot be removed: " + failed.message());
}

FolderLock::FolderLock(const fs::path& folder) {
  const fs::path file = folder / "lock";
  makeParent(file);
  descriptor_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor_ < 0) throw cannotWrite(file.string(), "cannot be created: " + messageOf(errno));
}

FolderLock::~FolderLock() {
  ::close(descriptor_);
}

// A file system without locks (some network mounts) lets everyone in: renames keep even that free of
// half-written files, and the cache's temporary folders belong to one process each.
bool FolderLock::tryLock() {
  return ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

}  // namespace bakelight::pipeline
