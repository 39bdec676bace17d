// Tables of numbers as they stand in a `.btf` file: halves, floats or doubles, row by row. Private to formats/.
#pragma once

#include <cstdint>
#include <cstring>
#include <Eigen/Core>
#include <span>
#include <string>

#include "formats/btf_cursor.h"

namespace bakelight::formats {

using BtfRows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

enum class BtfScalar : std::uint8_t { kHalf = 2, kFloat = 4, kDouble = 8 };

inline BtfScalar readBtfScalar(BtfCursor& cursor) {
  const std::uint64_t offset = cursor.offset();
  const auto size = cursor.read<std::uint8_t>("the size of a number");
  if (size != 2 && size != 4 && size != 8)
    throw cursor.error("numbers have " + std::to_string(size) + " bytes", "2, 4 or 8", offset);
  return static_cast<BtfScalar>(size);
}

class BtfScalars {
 public:
  BtfScalars() = default;
  BtfScalars(BtfCursor& cursor, BtfScalar scalar, std::uint64_t rows, std::uint64_t columns,
             const std::string& what)
      : scalar_(scalar),
        columns_(columns),
        bytes_(cursor.take(saturatedProduct({rows, columns, static_cast<std::uint64_t>(scalar)}), what)) {}

  std::size_t columns() const { return columns_; }

  void row(std::size_t index, float* values) const {
    const auto size = static_cast<std::size_t>(scalar_);
    const std::byte* from = bytes_.data() + index * columns_ * size;
    for (std::size_t i = 0; i < columns_; ++i, from += size) values[i] = value(from);
  }
  float at(std::size_t row, std::size_t column) const {
    return value(bytes_.data() + (row * columns_ + column) * static_cast<std::size_t>(scalar_));
  }
  // Row i is row indexOf(i).
  template <class IndexOf>
  BtfRows rows(std::size_t count, const IndexOf& indexOf) const {
    BtfRows result(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(columns_));
    for (std::size_t i = 0; i < count; ++i) row(indexOf(i), result.data() + i * columns_);
    return result;
  }

 private:
  template <class T>
  static T load(const std::byte* from) {
    T value;
    std::memcpy(&value, from, sizeof(T));
    return value;
  }
  float value(const std::byte* from) const {
    switch (scalar_) {
      case BtfScalar::kHalf:
        return static_cast<float>(Eigen::numext::bit_cast<Eigen::half>(load<std::uint16_t>(from)));
      case BtfScalar::kFloat:
        return load<float>(from);
      case BtfScalar::kDouble:
        break;
    }
    return static_cast<float>(load<double>(from));
  }

  BtfScalar scalar_ = BtfScalar::kFloat;
  std::size_t columns_ = 0;
  std::span<const std::byte> bytes_;
};

}  // namespace bakelight::formats
