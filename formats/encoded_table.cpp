#include "formats/encoded_table.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <Eigen/Core>
#include <limits>
#include <stdexcept>

#include "formats/error.h"

namespace bakelight::formats {
namespace {

constexpr float kLargestHalf = 65504;
constexpr float kLargestCoded = 1e38F;  // so that scale · 255 is a float, whatever the range
constexpr float kLargestCode = 255;

Error valueError(const std::string& file, const std::string& what, std::size_t row, std::size_t column,
                 const std::string& problem, const std::string& expected, const std::string& remedy) {
  return badInput({file, what + ", row " + std::to_string(row) + ", column " + std::to_string(column), ""},
                  problem, expected, remedy);
}

void checkValues(std::span<const float> values, std::size_t columns, Precision precision,
                 const std::string& file, const std::string& what) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) {
      throw valueError(file, what, i / columns, i % columns, "it is not finite", "a number",
                       "make the file again; the stage that wrote it went wrong");
    }
    if (precision == Precision::kFloat16 && std::abs(values[i]) > kLargestHalf) {
      throw valueError(file, what, i / columns, i % columns,
                       std::to_string(values[i]) + " does not fit a half float", "-65504 to 65504",
                       "choose precision float32 or uint8");
    }
    if (precision == Precision::kUint8 && std::abs(values[i]) > kLargestCoded) {
      throw valueError(file, what, i / columns, i % columns,
                       std::to_string(values[i]) + " is too large for 8-bit codes", "-1e38 to 1e38",
                       "choose precision float32");
    }
  }
}

std::uint16_t halfBits(float value) {
  return Eigen::numext::bit_cast<std::uint16_t>(Eigen::half(value));
}

float halfValue(std::uint16_t bits) {
  return static_cast<float>(Eigen::numext::bit_cast<Eigen::half>(bits));
}

// The step between codes of a column: a 255th of its range, never rounded down, so that the last code reaches
// the end of the range.
float stepOf(float least, float greatest) {
  const double range = static_cast<double>(greatest) - least;
  const auto step = static_cast<float>(range / kLargestCode);
  if (static_cast<double>(step) * kLargestCode >= range) return step;
  return std::nextafter(step, std::numeric_limits<float>::infinity());
}

void encodeHalves(std::span<const float> values, Bytes& data) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::uint16_t bits = halfBits(values[i]);
    std::memcpy(data.data() + i * sizeof bits, &bits, sizeof bits);
  }
}

void encodeCodes(std::span<const float> values, EncodedTable& table, Bytes& data) {
  std::vector<float> greatest(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(table.columns));
  table.offset = greatest;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t column = i % table.columns;
    table.offset[column] = std::min(table.offset[column], values[i]);
    greatest[column] = std::max(greatest[column], values[i]);
  }
  for (std::size_t column = 0; column < table.columns; ++column) {
    table.scale.push_back(stepOf(table.offset[column], greatest[column]));
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double scale = table.scale[i % table.columns], offset = table.offset[i % table.columns];
    const double code = scale > 0 ? std::round((values[i] - offset) / scale) : 0;
    data[i] = static_cast<std::byte>(static_cast<std::uint8_t>(code));
  }
}

}  // namespace

std::size_t bytesPerValue(Precision precision) {
  switch (precision) {
    case Precision::kFloat32:
      return 4;
    case Precision::kFloat16:
      return 2;
    case Precision::kUint8:
      return 1;
  }
  throw std::logic_error("a precision without a size");
}

std::vector<float> EncodedTable::decode() const {
  std::vector<float> values(rows * columns);
  switch (precision) {
    case Precision::kFloat32:
      if (!values.empty()) std::memcpy(values.data(), data.data(), values.size() * sizeof(float));
      break;
    case Precision::kFloat16:
      for (std::size_t i = 0; i < values.size(); ++i) {
        std::uint16_t bits;
        std::memcpy(&bits, data.data() + i * sizeof bits, sizeof bits);
        values[i] = halfValue(bits);
      }
      break;
    case Precision::kUint8:
      for (std::size_t i = 0; i < values.size(); ++i) {
        const auto code = static_cast<float>(std::to_integer<int>(data[i]));
        values[i] = offset[i % columns] + scale[i % columns] * code;
      }
      break;
  }
  return values;
}

EncodedTable encodeTable(std::span<const float> values, std::size_t columns, Precision precision,
                         const std::string& file, const std::string& what) {
  if (columns == 0 || values.size() % columns != 0) {
    throw std::invalid_argument("a table's values are no whole number of rows");
  }
  checkValues(values, columns, precision, file, what);
  EncodedTable table{precision, values.size() / columns, columns, {}, {}, {}};
  Bytes data(values.size() * bytesPerValue(precision));
  if (values.empty()) return table;
  if (precision == Precision::kFloat32) std::memcpy(data.data(), values.data(), data.size());
  if (precision == Precision::kFloat16) encodeHalves(values, data);
  if (precision == Precision::kUint8) encodeCodes(values, table, data);
  table.data = std::move(data);
  return table;
}

}  // namespace bakelight::formats
