#include "formats/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>

#include "formats/atomic_file.h"
#include "formats/error.h"

namespace bakelight::formats {
namespace fs = std::filesystem;
namespace {

std::string systemMessage(int error) {
  return std::strerror(error);
}

// Closes on every path out; close errors matter only where they are asked for.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return number_; }
  bool valid() const { return number_ >= 0; }
  bool close() {
    const int number = number_;
    number_ = -1;
    return ::close(number) == 0;
  }

 private:
  int number_;
};

void writeAll(const Descriptor& file, std::uint64_t offset, std::span<const std::byte> bytes,
              const fs::path& path) {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(file.get(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw cannotWrite(path.string(), "writing failed: " + systemMessage(errno));
    bytes = bytes.subspan(static_cast<std::size_t>(written));
    offset += static_cast<std::uint64_t>(written);
  }
}

// The temporary file being filled, for removeUnfinishedFile. A handler may run at any instant, so the name
// sits in a fixed buffer and the flag is raised only while the buffer is whole. One writer at a time owns the
// buffer; a second thread that writes meanwhile goes unregistered, which costs a stray file at worst.
constexpr std::size_t kMaxNameLength = 4096;
char unfinished_name[kMaxNameLength];
std::atomic<bool> unfinished_owned{false}, unfinished_set{false};

class UnfinishedFile {
 public:
  explicit UnfinishedFile(const std::string& name)
      : owner_(name.size() < kMaxNameLength && !unfinished_owned.exchange(true)) {
    if (!owner_) return;
    name.copy(unfinished_name, name.size());
    unfinished_name[name.size()] = '\0';
    unfinished_set = true;
  }
  ~UnfinishedFile() {
    if (!owner_) return;
    unfinished_set = false;
    unfinished_owned = false;
  }
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

 private:
  bool owner_;
};

// Unique among the threads and processes of this machine.
fs::path temporaryNameFor(const fs::path& path) {
  static std::atomic<unsigned> counter{0};
  fs::path name = path;
  name += ".tmp-" + std::to_string(::getpid()) + "-" + std::to_string(counter++);
  return name;
}

}  // namespace

Bytes readFile(const fs::path& path) {
  const auto refuse = [&](const std::string& what) {
    return badInput({path.string(), "", ""}, what, "a file that can be read",
                    "check the path and its permissions");
  };
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.valid()) throw refuse("cannot be opened: " + systemMessage(errno));
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) throw refuse("cannot be examined: " + systemMessage(errno));
  if (S_ISDIR(status.st_mode)) throw refuse("is a folder");

  // The end is looked for with a block of its own, so that a file of the size it states is held once. Pipes
  // and /proc files state none: grow as long as something comes.
  Bytes bytes(static_cast<std::size_t>(status.st_size));
  std::array<std::byte, 65536> beyond;
  std::size_t filled = 0;
  while (true) {
    const bool full = filled == bytes.size();
    const ssize_t got = full ? ::read(file.get(), beyond.data(), beyond.size())
                             : ::read(file.get(), bytes.data() + filled, bytes.size() - filled);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw refuse("cannot be read: " + systemMessage(errno));
    if (got == 0) break;
    if (full) bytes.insert(bytes.end(), beyond.begin(), beyond.begin() + got);
    filled += static_cast<std::size_t>(got);
  }
  bytes.resize(filled);
  return bytes;
}

std::string readTextFile(const fs::path& path) {
  const Bytes bytes = readFile(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string lowerEnding(const fs::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return ending;
}

namespace {

int createFor(const fs::path& path, const fs::path& temporary) {
  std::error_code failed;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), failed);
  if (failed) throw cannotWrite(path.string(), "its folder cannot be made: " + failed.message());
  const int number = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (number < 0) throw cannotWrite(path.string(), "cannot be created: " + systemMessage(errno));
  return number;
}

}  // namespace

struct AtomicFile::Implementation {
  explicit Implementation(const fs::path& final_path)
      : path(final_path),
        temporary(temporaryNameFor(final_path)),
        registered(temporary.string()),
        file(createFor(path, temporary)) {}

  fs::path path, temporary;
  UnfinishedFile registered;
  Descriptor file;
  bool finished = false;
};

AtomicFile::AtomicFile(const fs::path& path) : implementation_(std::make_unique<Implementation>(path)) {}

AtomicFile::~AtomicFile() {
  if (!implementation_->finished) ::unlink(implementation_->temporary.c_str());
}

void AtomicFile::writeAt(std::uint64_t offset, std::span<const std::byte> bytes) {
  writeAll(implementation_->file, offset, bytes, implementation_->path);
}

void AtomicFile::finish() {
  const fs::path& path = implementation_->path;
  Descriptor& file = implementation_->file;
  // Without the sync a crash soon after the rename can leave an empty file under the final name.
  if (::fsync(file.get()) != 0) throw cannotWrite(path.string(), "writing failed: " + systemMessage(errno));
  if (!file.close()) throw cannotWrite(path.string(), "writing failed: " + systemMessage(errno));
  if (::rename(implementation_->temporary.c_str(), path.c_str()) != 0)
    throw cannotWrite(path.string(), "cannot be put in place: " + systemMessage(errno));
  implementation_->finished = true;
  syncFolderOf(path);
}

void writeFileAtomically(const fs::path& path, std::span<const std::byte> bytes) {
  AtomicFile file(path);
  file.writeAt(0, bytes);
  file.finish();
}

void syncFolderOf(const fs::path& path) noexcept {
  const std::string folder = path.has_parent_path() ? path.parent_path().string() : ".";
  const Descriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (opened.valid()) ::fsync(opened.get());
}

void writeFileAtomically(const fs::path& path, std::string_view text) {
  writeFileAtomically(path, std::as_bytes(std::span(text)));
}

void removeUnfinishedFile() noexcept {
  if (unfinished_set) ::unlink(unfinished_name);
}

}  // namespace bakelight::formats
