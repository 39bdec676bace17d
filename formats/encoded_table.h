// Tables of one row a vertex (or a basis matrix) at the precision in which they are stored and played back.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "formats/shared_bytes.h"
#include "formats/words.h"

namespace bakelight::formats {

enum class Precision { kFloat32, kFloat16, kUint8 };

std::size_t bytesPerValue(Precision precision);  // 4, 2, 1
inline constexpr Word<Precision> kPrecisions[] = {
    {"float32", Precision::kFloat32}, {"float16", Precision::kFloat16}, {"uint8", Precision::kUint8}};
constexpr const char* nameOf(Precision precision) {
  return wordFor(kPrecisions, precision);
}

// Row-major, rows × columns. kUint8: value = offset[column] + scale[column] · code; the other two are IEEE
// 754 numbers and `scale` and `offset` are empty.
struct EncodedTable {
  Precision precision = Precision::kFloat32;
  std::size_t rows = 0, columns = 0;
  SharedBytes data;                  // rows · columns · bytesPerValue
  std::vector<float> scale, offset;  // a column; kUint8 only

  bool empty() const { return rows == 0; }
  std::size_t rowBytes() const { return columns * bytesPerValue(precision); }
  std::vector<float> decode() const;
};

// Rounds to nearest (ties to even for halves), so kUint8 errs by half a step of the column at most, a 510th
// of the column's range; a column whose values are all equal is exact then. `values` holds rows × columns.
// Throws Error(kBadInput) naming `file`, `what`, row and column for a value that is not finite, that does not
// fit a half (|x| > 65504) or 8-bit codes (|x| > 1e38). `values.size()` must be a multiple of `columns`
// (std::invalid_argument).
EncodedTable encodeTable(std::span<const float> values, std::size_t columns, Precision precision,
                         const std::string& file, const std::string& what);

}  // namespace bakelight::formats
