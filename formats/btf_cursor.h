// Reads the bytes of a `.btf` file from front to back; whatever is not there is an error with its offset. Private to
// formats/.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "formats/error.h"

namespace bakelight::formats {

// The product, or the largest number if it does not fit.
inline std::uint64_t saturatedProduct(std::initializer_list<std::uint64_t> factors) {
  std::uint64_t product = 1;
  for (const std::uint64_t factor : factors)
    if (__builtin_mul_overflow(product, factor, &product)) return UINT64_MAX;
  return product;
}

class BtfCursor {
 public:
  BtfCursor(std::span<const std::byte> bytes, std::string file) : bytes_(bytes), file_(std::move(file)) {}

  std::uint64_t offset() const { return offset_; }
  std::uint64_t left() const { return bytes_.size() - offset_; }
  const std::string& file() const { return file_; }

  Error error(const std::string& what, const std::string& expected, std::uint64_t offset,
              const std::string& remedy = "the file is damaged: fetch it again") const {
    return badInput({file_, "offset " + std::to_string(offset), ""}, what, expected, remedy);
  }
  Error error(const std::string& what, const std::string& expected = "") const {
    return error(what, expected, offset_);
  }

  // The next `count` bytes, that are `what`.
  std::span<const std::byte> take(std::uint64_t count, const std::string& what) {
    if (count > left())
      throw error("the file ends within " + what + ": " + std::to_string(left()) + " bytes are left",
                  count == UINT64_MAX ? "sizes that fit a file" : std::to_string(count) + " bytes");
    const auto taken = bytes_.subspan(offset_, count);
    offset_ += count;
    return taken;
  }
  template <class T>
  T read(const std::string& what) {
    T value;
    std::memcpy(&value, take(sizeof(T), what).data(), sizeof(T));
    return value;
  }
  std::uint32_t readCount(const std::string& what) { return read<std::uint32_t>(what); }
  // To its first NUL, or all of it.
  std::string readText(std::uint64_t count, const std::string& what) {
    const auto taken = take(count, what);
    const std::string text(reinterpret_cast<const char*>(taken.data()), taken.size());
    return text.substr(0, text.find('\0'));
  }
  void requireEnd() const {
    if (left() != 0)
      throw error(std::to_string(left()) + " bytes follow what its sizes account for", "the end of the file");
  }

 private:
  std::span<const std::byte> bytes_;
  std::string file_;
  std::uint64_t offset_ = 0;
};

}  // namespace bakelight::formats
