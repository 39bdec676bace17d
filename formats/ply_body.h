// The values of a PLY file's body, one after the other, in its three encodings. Private to
// formats/ply_parts.cpp.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "formats/error.h"
#include "formats/ply_header.h"

namespace bakelight::formats {

const char* nameOf(PlyScalar type);

// A place in the body, for messages: "vertex 5", and its line in a text.
struct PlyRow {
  const PlyElement* element = nullptr;
  std::uint64_t row = 0;
  std::uint64_t line = 0;  // 0: not a text

  std::string text() const;
};

Error plyEndsHere(const std::string& file, const PlyRow& row);

// Both bodies have the same functions. Those that take throw Error(kBadInput) naming the file and the row
// where the body ends too early or a value is none of its type.
class PlyTextBody {
 public:
  PlyTextBody(const PlyHeader& header, std::span<const std::byte> bytes, std::string file);

  void beginRow(const PlyElement& element, std::uint64_t row);
  const PlyRow& row() const { return row_; }
  float takeFloat(PlyScalar type);  // the nearest
  std::int64_t takeInteger(PlyScalar type);
  void skip(PlyScalar type, std::uint64_t count);
  std::uint64_t bytesLeft() const { return text_.size() - position_; }
  // After the last row. Words that follow are an error if rows did not end with their lines, and else noted.
  std::optional<std::string> finish();

 private:
  bool skipBlanks();  // whether a line end was among them
  std::string_view takeWord();
  Error notOf(PlyScalar type, std::string_view word) const;
  // Rows that do not end with their lines are the cause of what goes wrong after them.
  void throwIfMisaligned() const;

  std::string_view text_;
  std::string file_;
  std::size_t position_ = 0;
  std::uint64_t line_ = 0;
  PlyRow row_;
  std::optional<PlyRow> misaligned_;
};

template <std::endian kEndian>
class PlyBinaryBody {
 public:
  PlyBinaryBody(const PlyHeader& header, std::span<const std::byte> bytes, std::string file)
      : bytes_(bytes.subspan(header.size_bytes)), file_(std::move(file)) {}

  void beginRow(const PlyElement& element, std::uint64_t row) { row_ = {&element, row, 0}; }
  const PlyRow& row() const { return row_; }

  float takeFloat(PlyScalar type) {
    if (type == PlyScalar::kFloat32) return take<float>();
    if (type == PlyScalar::kFloat64) return static_cast<float>(take<double>());
    return static_cast<float>(takeInteger(type));
  }

  std::int64_t takeInteger(PlyScalar type) {
    switch (type) {
      case PlyScalar::kInt8:
        return take<std::int8_t>();
      case PlyScalar::kUint8:
        return take<std::uint8_t>();
      case PlyScalar::kInt16:
        return take<std::int16_t>();
      case PlyScalar::kUint16:
        return take<std::uint16_t>();
      case PlyScalar::kInt32:
        return take<std::int32_t>();
      case PlyScalar::kUint32:
        return take<std::uint32_t>();
      default:
        return takeWhole(type == PlyScalar::kFloat32 ? take<float>() : take<double>());
    }
  }

  void skip(PlyScalar type, std::uint64_t count) {
    if (count > bytesLeft() / sizeOf(type)) throw plyEndsHere(file_, row_);
    position_ += static_cast<std::size_t>(count) * sizeOf(type);
  }

  std::uint64_t bytesLeft() const { return bytes_.size() - position_; }

  std::optional<std::string> finish() const {
    if (bytesLeft() == 0) return std::nullopt;
    return std::to_string(bytesLeft()) +
           " bytes follow the last element that the header names, and were not read";
  }

 private:
  template <class T>
  T take() {
    if (sizeof(T) > bytesLeft()) throw plyEndsHere(file_, row_);
    std::byte raw[sizeof(T)];
    for (std::size_t i = 0; i < sizeof(T); ++i)
      raw[kEndian == std::endian::native ? i : sizeof(T) - 1 - i] = bytes_[position_ + i];
    position_ += sizeof(T);
    T value;
    std::memcpy(&value, raw, sizeof(T));
    return value;
  }

  std::int64_t takeWhole(double value) const {
    const auto whole = static_cast<std::int64_t>(value >= -1e18 && value <= 1e18 ? value : 0);
    if (static_cast<double>(whole) != value)
      throw badInput({file_, row_.text(), ""}, std::to_string(value) + " is not an integer", "an index");
    return whole;
  }

  std::span<const std::byte> bytes_;
  std::string file_;
  std::size_t position_ = 0;
  PlyRow row_;
};

}  // namespace bakelight::formats
