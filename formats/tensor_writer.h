// Safetensors files written as their values come, so that no array need be in memory as a whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "formats/atomic_file.h"
#include "formats/tensors.h"

namespace bakelight::formats {

// The file has the bytes that encodeSafetensors gives for the same arrays, in whatever blocks they come. It
// stands under a temporary name until `finish`; without that nothing is left of it.
class TensorWriter {
 public:
  // Throws Error(kCannotWrite) as writeFileAtomically, and std::logic_error for sizes that overflow.
  TensorWriter(const std::filesystem::path& path, const std::map<std::string, TensorShape>& tensors,
               const std::map<std::string, std::string>& metadata);

  // The next values of an array, row-major and in whole; arrays may take turns. Throws Error(kCannotWrite),
  // and std::logic_error for values beyond the end, or of another size than the array's type.
  template <class T>
  void append(const std::string& name, std::span<const T> values) {
    appendBytes(name, sizeof(T), std::as_bytes(values));
  }
  // The next values as they are in memory.
  void append(const std::string& name, std::span<const std::byte> bytes) { appendBytes(name, 1, bytes); }
  // Throws std::logic_error if an array lacks values, and Error(kCannotWrite).
  void finish();

 private:
  struct Place {
    std::size_t element_size;
    std::uint64_t next, end;  // bytes in the file
  };
  void appendBytes(const std::string& name, std::size_t element_size, std::span<const std::byte> bytes);

  AtomicFile file_;
  std::map<std::string, Place> places_;
};

}  // namespace bakelight::formats
