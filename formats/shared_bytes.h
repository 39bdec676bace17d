// Bytes that never change, owned together: those of a table are copied by reference, and a pack that was
// opened by mapping its file points into the file.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <utility>

#include "formats/file.h"

namespace bakelight::formats {

class SharedBytes {
 public:
  SharedBytes() = default;
  // Owns `bytes`.
  SharedBytes(Bytes bytes) {
    auto owned = std::make_shared<const Bytes>(std::move(bytes));
    bytes_ = *owned;
    owner_ = std::move(owned);
  }
  // Points at `bytes`, which live as long as `owner`.
  SharedBytes(std::span<const std::byte> bytes, std::shared_ptr<const void> owner)
      : bytes_(bytes), owner_(std::move(owner)) {}

  const std::byte* data() const { return bytes_.data(); }
  std::size_t size() const { return bytes_.size(); }
  bool empty() const { return bytes_.empty(); }
  const std::byte& operator[](std::size_t i) const { return bytes_[i]; }
  auto begin() const { return bytes_.begin(); }
  auto end() const { return bytes_.end(); }
  operator std::span<const std::byte>() const { return bytes_; }

  bool operator==(const SharedBytes& other) const {
    return std::equal(begin(), end(), other.begin(), other.end());
  }

 private:
  std::span<const std::byte> bytes_;
  std::shared_ptr<const void> owner_;
};

}  // namespace bakelight::formats
