// A file in memory without a copy: its pages come from the disk as they are read, and may go again.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

#include "formats/shared_bytes.h"

namespace bakelight::formats {

class MappedFile {
 public:
  // Throws Error(kBadInput) as readFile. The file must not be cut short by others meanwhile: files that were
  // written by writeFileAtomically are replaced, never changed.
  static std::shared_ptr<const MappedFile> open(const std::filesystem::path& path);
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();

  std::span<const std::byte> bytes() const { return bytes_; }
  // Gives the memory of `part` back until it is read again. Best effort.
  void release(std::span<const std::byte> part) const noexcept;

 private:
  explicit MappedFile(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::span<const std::byte> bytes_;
};

}  // namespace bakelight::formats
