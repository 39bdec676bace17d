// An array on the disk that grows to a length nobody knows before: what a file states before its data.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

namespace bakelight::transfer {

class ScratchArray {
 public:
  // A file without a name beside `path`: it is gone with the process, whatever happens. Throws Error(kCannotWrite).
  explicit ScratchArray(const std::filesystem::path& path);
  ~ScratchArray();
  ScratchArray(const ScratchArray&) = delete;
  ScratchArray& operator=(const ScratchArray&) = delete;

  void append(std::span<const std::byte> bytes);
  // All that was appended, in its order, by parts.
  void replay(const std::function<void(std::span<const std::byte>)>& take) const;

 private:
  std::filesystem::path path_;
  int file_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace bakelight::transfer
