// What writeFileAtomically does, for content that does not come at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

namespace bakelight::formats {

// A file written by parts: under a temporary name, which takes the place of `path` when it is finished and
// goes if it never is. Throws as writeFileAtomically.
class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  // In any order; what is never written between other parts is zeros.
  void writeAt(std::uint64_t offset, std::span<const std::byte> bytes);
  void finish();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace bakelight::formats
