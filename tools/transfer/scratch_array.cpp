#include "tools/transfer/scratch_array.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "formats/error.h"

namespace bakelight::transfer {

namespace {

Error failure(const std::filesystem::path& path, const char* what) {
  return cannotWrite(path.string(), std::string(what) + ": " + std::strerror(errno));
}

}  // namespace

ScratchArray::ScratchArray(const std::filesystem::path& path) : path_(path) {
  std::error_code failed;
  if (!path.parent_path().empty()) std::filesystem::create_directories(path.parent_path(), failed);
  if (failed) throw cannotWrite(path.string(), "its folder cannot be made: " + failed.message());
  std::string name = path.string() + ".scratch-XXXXXX";
  file_ = ::mkstemp(name.data());
  if (file_ < 0) throw failure(path, "a file beside it cannot be created");
  ::unlink(name.c_str());
}

ScratchArray::~ScratchArray() {
  ::close(file_);
}

void ScratchArray::append(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(file_, bytes.data(), bytes.size(), static_cast<off_t>(size_));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw failure(path_, "writing a file beside it failed");
    bytes = bytes.subspan(static_cast<std::size_t>(written));
    size_ += static_cast<std::uint64_t>(written);
  }
}

void ScratchArray::replay(const std::function<void(std::span<const std::byte>)>& take) const {
  constexpr std::size_t kPart = std::size_t{1} << 22;
  std::vector<std::byte> part(kPart);
  // Parts are filled up, so that they end between values.
  for (std::uint64_t at = 0; at < size_;) {
    const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(kPart, size_ - at));
    std::size_t filled = 0;
    while (filled < wanted) {
      const ssize_t got =
          ::pread(file_, part.data() + filled, wanted - filled, static_cast<off_t>(at + filled));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) throw failure(path_, "reading a file beside it failed");
      filled += static_cast<std::size_t>(got);
    }
    take(std::span(part).first(wanted));
    at += wanted;
  }
}

}  // namespace bakelight::transfer
