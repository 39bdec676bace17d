// The container of RGL's .bsdf files: named arrays. Private to tools/brdf.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace bakelight::brdf {

struct TensorField {
  int type = 0;  // as the file numbers them: 10 is a 32-bit float, 1 a byte
  std::vector<std::uint64_t> shape;
  std::uint64_t count = 1;           // of elements
  std::span<const std::byte> bytes;  // within the file's
};

// Throws Error(kBadInput) naming `file` and offset or field.
std::map<std::string, TensorField> readTensorFields(std::span<const std::byte> bytes,
                                                    const std::string& file);

}  // namespace bakelight::brdf
