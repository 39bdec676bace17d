#include "formats/encoded_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "formats/error.h"

namespace bakelight::formats {
namespace {

using testing::AllOf;
using testing::HasSubstr;

EncodedTable encode(const std::vector<float>& values, std::size_t columns, Precision precision) {
  return encodeTable(values, columns, precision, "a.safetensors", "tensor matrix");
}

// IEEE 754 binary16, from its definition.
double halfByDefinition(std::uint16_t bits) {
  const int exponent = (bits >> 10) & 31, mantissa = bits & 1023;
  const double magnitude =
      exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
  return (bits & 0x8000) != 0 ? -magnitude : magnitude;
}

bool isFiniteHalf(std::uint32_t bits) {
  return (bits & 0x7C00) != 0x7C00;
}

std::uint16_t encodedHalf(float value) {
  const EncodedTable table = encode({value}, 1, Precision::kFloat16);
  std::uint16_t bits;
  std::memcpy(&bits, table.data.data(), sizeof bits);
  return bits;
}

// Wavy columns of different range and offset; column 3 is constant.
std::vector<float> wavyTable(std::size_t rows, std::size_t columns) {
  std::vector<float> values;
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      const double wave = std::sin(0.37 * static_cast<double>(row) + static_cast<double>(column));
      const double amplitude = column == 3 ? 0 : std::pow(10.0, static_cast<double>(column) - 4);
      values.push_back(static_cast<float>(0.1 * static_cast<double>(column) + amplitude * wave));
    }
  }
  return values;
}

TEST(EncodedTable, SizesAndNames) {
  EXPECT_THAT(textsOf(kPrecisions), testing::ElementsAre("float32", "float16", "uint8"));
  for (const Word<Precision>& word : kPrecisions) EXPECT_STREQ(nameOf(word.value), word.text);
  const std::size_t bytes[] = {4, 2, 1};
  for (int i = 0; i < 3; ++i) {
    const auto precision = static_cast<Precision>(i);
    EXPECT_EQ(bytesPerValue(precision), bytes[i]);
    const EncodedTable table = encode(wavyTable(7, 5), 5, precision);
    EXPECT_EQ(table.rows, 7U);
    EXPECT_EQ(table.columns, 5U);
    EXPECT_EQ(table.rowBytes(), 5 * bytes[i]);
    EXPECT_EQ(table.data.size(), 35 * bytes[i]);
    EXPECT_EQ(table.scale.size(), precision == Precision::kUint8 ? 5U : 0U);
    EXPECT_EQ(table.offset.size(), table.scale.size());
  }
}

TEST(EncodedTable, Float32IsBitForBit) {
  const std::vector<float> values = {
      0,      -0.0F, 1.0F / 3, std::numeric_limits<float>::denorm_min(), std::numeric_limits<float>::max(),
      -1e-20F};
  const std::vector<float> decoded = encode(values, 2, Precision::kFloat32).decode();
  ASSERT_EQ(decoded.size(), values.size());
  EXPECT_EQ(std::memcmp(decoded.data(), values.data(), values.size() * sizeof(float)), 0);
}

TEST(EncodedTable, EachOfThe65536HalvesDecodesByDefinitionAndEncodesToItself) {
  Bytes codes(65536 * 2);
  for (std::uint32_t bits = 0; bits < 65536; ++bits) {
    const auto code = static_cast<std::uint16_t>(bits);
    std::memcpy(codes.data() + 2 * bits, &code, 2);
  }
  const EncodedTable table{Precision::kFloat16, 65536, 1, std::move(codes), {}, {}};
  const std::vector<float> decoded = table.decode();
  int finite = 0;
  for (std::uint32_t bits = 0; bits < 65536; ++bits) {
    if (!isFiniteHalf(bits)) {
      EXPECT_FALSE(std::isfinite(decoded[bits]));
      continue;
    }
    ++finite;
    const auto code = static_cast<std::uint16_t>(bits);
    ASSERT_EQ(decoded[bits], halfByDefinition(code)) << bits;
    ASSERT_EQ(encodedHalf(decoded[bits]), code) << bits;
  }
  EXPECT_EQ(finite, 2 * 31 * 1024);
}

TEST(EncodedTable, HalvesRoundToNearestTiesToEven) {
  // Between each pair of neighbours, subnormal ones included: the middle goes to the even code, and the next
  // float on either side of the middle to the nearer one.
  for (std::uint32_t bits = 0; isFiniteHalf(bits + 1); ++bits) {
    const auto lower = static_cast<std::uint16_t>(bits), upper = static_cast<std::uint16_t>(bits + 1);
    const auto middle = static_cast<float>((halfByDefinition(lower) + halfByDefinition(upper)) / 2);
    ASSERT_EQ(encodedHalf(middle), lower % 2 == 0 ? lower : upper) << bits;
    ASSERT_EQ(encodedHalf(std::nextafter(middle, 0.0F)), lower) << bits;
    ASSERT_EQ(encodedHalf(std::nextafter(middle, 1e9F)), upper) << bits;
    ASSERT_EQ(encodedHalf(-middle), (lower % 2 == 0 ? lower : upper) | 0x8000) << bits;
  }
}

TEST(EncodedTable, CodesErrByHalfAStepAtMost) {
  constexpr std::size_t kColumns = 8;
  const std::vector<float> values = wavyTable(1000, kColumns);
  const EncodedTable table = encode(values, kColumns, Precision::kUint8);
  const std::vector<float> decoded = table.decode();
  ASSERT_EQ(decoded.size(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t column = i % kColumns;
    const double rounding = 1e-7 * (std::abs(table.offset[column]) + 255 * table.scale[column]);
    ASSERT_LE(std::abs(static_cast<double>(decoded[i]) - values[i]), 0.5 * table.scale[column] + rounding)
        << i;
  }
}

TEST(EncodedTable, CodesUseTheWholeRangeOfAColumn) {
  const EncodedTable table = encode({-1, 10, 0, 20, 4, 14}, 2, Precision::kUint8);
  const std::vector<int> codes = {0, 0, 51, 255, 255, 102};
  for (std::size_t i = 0; i < codes.size(); ++i)
    EXPECT_EQ(std::to_integer<int>(table.data[i]), codes[i]) << i;
  EXPECT_FLOAT_EQ(table.scale[0], 5.0F / 255);
  EXPECT_EQ(table.offset[1], 10);
}

TEST(EncodedTable, AConstantColumnIsExactInCodes) {
  for (const float constant : {0.0F, 0.1F, -3.75F, 1e-30F}) {
    const std::vector<float> values(9, constant);
    EXPECT_EQ(encode(values, 3, Precision::kUint8).decode(), values);
  }
}

TEST(EncodedTable, ExtremeRangesNeitherOverflowNorWrap) {
  const float tiny = std::numeric_limits<float>::denorm_min();
  const std::vector<float> wide = encode({-1e38F, 1e38F, 0}, 1, Precision::kUint8).decode();
  EXPECT_NEAR(wide[0] / 1e38F, -1, 1e-6);
  EXPECT_NEAR(wide[1] / 1e38F, 1, 1e-6);
  EXPECT_NEAR(wide[2] / 1e38F, 0, 1.0 / 255);
  // Steps among subnormals cannot be finer than the smallest float.
  const std::vector<float> narrow = {0, 100 * tiny, 3 * tiny};
  EXPECT_EQ(encode(narrow, 1, Precision::kUint8).decode(), narrow);
}

std::string errorOf(const std::vector<float>& values, Precision precision) {
  try {
    encode(values, 2, precision);
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    return error.what();
  }
  return "no error";
}

TEST(EncodedTable, ValuesThatDoNotFitAreNamed) {
  for (const Precision precision : {Precision::kFloat32, Precision::kFloat16, Precision::kUint8}) {
    EXPECT_THAT(errorOf({0, 0, 0, std::nanf("")}, precision),
                AllOf(HasSubstr("a.safetensors"), HasSubstr("tensor matrix, row 1, column 1")));
    EXPECT_THAT(errorOf({0, -INFINITY}, precision), HasSubstr("not finite"));
  }
  EXPECT_EQ(errorOf({65504, -65504}, Precision::kFloat16), "no error");
  EXPECT_THAT(errorOf({0, 0, 65504.004F, 0}, Precision::kFloat16),
              AllOf(HasSubstr("row 1"), HasSubstr("half")));
  EXPECT_EQ(errorOf({1e9F, 0}, Precision::kUint8), "no error");
  EXPECT_THAT(errorOf({0, -2e38F}, Precision::kUint8), HasSubstr("row 0, column 1"));
  EXPECT_THROW(encode({1, 2, 3}, 2, Precision::kFloat32), std::invalid_argument);
  EXPECT_THROW(encode({1, 2, 3}, 0, Precision::kFloat32), std::invalid_argument);
}

TEST(EncodedTable, NoRowsIsATable) {
  const EncodedTable table = encode({}, 4, Precision::kUint8);
  EXPECT_TRUE(table.empty());
  EXPECT_TRUE(table.decode().empty());
}

}  // namespace
}  // namespace bakelight::formats
