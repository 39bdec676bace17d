#include "compression/shared_sums.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>
#include <map>

#include "compression/tolerance.h"
#include "formats/error.h"
#include "formats/sum_grammar_file.h"
#include "tests/support/pixel_rows.h"
#include "transport/cube_map.h"
#include "transport/sum_product.h"

namespace bakelight::compression {
namespace {

using formats::PixelCodes;
using formats::PixelRows;
using formats::SumGrammar;
using namespace tests;
using transport::Radiance4;

// Each entry with a column and a code that no other has, as far as there are such.
PixelRows allDistinct() {
  PixelRows rows = emptyRows(32, 1, 15);
  for (int row = 0; row < 600; ++row) {
    for (int i = 0; i < 1000; ++i) rows.columns.push_back(static_cast<std::uint16_t>(i * 6 + row % 6));
    for (int i = 0; i < 1000; ++i) rows.codes.push_back(static_cast<std::uint8_t>(1 + row / 6 * 2 % 225));
    rows.row_offsets.push_back(rows.columns.size());
  }
  return rows;
}

struct Case {
  const char* name;
  std::function<PixelRows()> rows;
};
void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

const Case kCases[] = {
    {"Structured", [] { return ballRows(60, 16, 8, 2); }},
    {"OneVertex", [] { return ballRows(1, 32, 8, 2); }},
    {"NothingBlocked", [] { return ballRows(20, 16, 8, 2, 2); }},
    {"AllBlocked", [] { return ballRows(5, 8, 8, 2, -2); }},
    {"FlippedFrames", [] { return ballRows(20, 16, 8, 2, 0.8, true); }},
    {"FineDirections", [] { return ballRows(3, 32, 32, 2); }},
    {"ManyCodes", [] { return ballRows(12, 12, 4, 15); }},
    {"WholeTexels", [] { return ballRows(12, 10, 4, 1); }},
    {"OddSide", [] { return ballRows(6, 7, 3, 3); }},
    {"LargestMap", [] { return ballRows(2, 104, 8, 2); }},
    {"Noise", [] { return noiseRows(2000, 40, 16, 3); }},
    {"LongRows", [] { return noiseRows(20, 3000, 32, 2); }},
    {"AllDistinct", [] { return allDistinct(); }},
    {"NoRows", [] { return emptyRows(32, 8, 2); }},
};

class Compressed : public testing::TestWithParam<Case> {};

std::vector<Radiance4> sunAndSky(std::size_t texels) {
  std::vector<Radiance4> light(texels);
  for (std::size_t k = 0; k < texels; ++k)
    light[k] =
        Radiance4(1.0F + 0.001F * static_cast<float>(k % 97), 0.7F, 0.3F, 0) * (k % 501 == 250 ? 1e6F : 1.0F);
  return light;
}

TEST_P(Compressed, GivesEveryRowBack) {
  const PixelRows rows = GetParam().rows();
  const SumGrammar grammar = compress(rows.view());
  EXPECT_TRUE(sameRows(decode(grammar), rows));
  EXPECT_EQ(reconstructionErrors(grammar, rows.view()), 0U);
}

TEST_P(Compressed, SurvivesItsFile) {
  const PixelRows rows = GetParam().rows();
  const SumGrammar grammar = compress(rows.view());
  const formats::Bytes bytes = formats::encodeSafetensors(formats::encodeSumGrammar(grammar));
  const SumGrammar loaded = formats::decodeSumGrammar(formats::decodeSafetensors(bytes, "file"), "file");
  EXPECT_EQ(loaded.terms, grammar.terms);
  EXPECT_EQ(loaded.sum_parts, grammar.sum_parts);
  EXPECT_EQ(loaded.level_ends, grammar.level_ends);
  EXPECT_TRUE(sameRows(decode(loaded), rows));
}

// Against sums in double precision, of the largest light that there may be and the least.
TEST_P(Compressed, AddsUpToARounding) {
  const PixelRows rows = GetParam().rows();
  const PixelCodes codes = rows.view();
  const SumGrammar grammar = compress(codes);
  const std::vector<Radiance4> light = sunAndSky(codes.columnCount());
  std::vector<Radiance4> values(grammar.row_places.size());
  transport::multiply(grammar, light, values);
  const std::vector<std::uint32_t> places = transport::valuePlaces(grammar);
  double worst = 0;
  for (std::size_t row = 0; row < codes.rowCount(); ++row) {
    double sum = 0;
    for (std::uint64_t i = codes.row_offsets[row]; i < codes.row_offsets[row + 1]; ++i)
      sum += static_cast<double>(light[codes.columns[i]][0]) * codes.codes[i] /
             (codes.subsamples * codes.subsamples);
    ASSERT_EQ(places[row] == transport::kNoValue, sum == 0) << row;
    if (sum > 0) worst = std::max(worst, std::abs(values[places[row]][0] / sum - 1));
  }
  // An addition of positive numbers errs by 2⁻²⁴ of its result at most.
  std::size_t terms = 0, levels = 0;
  for (const formats::RowGroup& group : grammar.groups) terms = std::max<std::size_t>(terms, group.terms);
  for (std::size_t tile = 0; tile < grammar.tileCount(); ++tile)
    levels = std::max<std::size_t>(levels, grammar.tiles[tile + 1].level - grammar.tiles[tile].level);
  const std::size_t additions = 2 + terms + levels;
  EXPECT_LE(worst, static_cast<double>(additions) * 0x1p-24);
  EXPECT_LT(worst, GetParam().name == std::string("Structured") ? 4e-7 : 1);
}

TEST_P(Compressed, IsTheSameOnOneThread) {
  const PixelRows rows = GetParam().rows();
  const auto bytes = [&] {
    return formats::encodeSafetensors(formats::encodeSumGrammar(compress(rows.view(), {512, 2})));
  };
  const formats::Bytes many = bytes();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(bytes(), many);
}

TEST_P(Compressed, IsNeverMoreWorkOrMemoryThanTheRows) {
  const PixelRows rows = GetParam().rows();
  const SumGrammar grammar = compress(rows.view());
  const std::size_t entries = rows.columns.size();
  // The light times each code is worked out once, whatever the rows.
  const std::uint64_t scaling = grammar.subsamples * grammar.subsamples * grammar.columnCount();
  EXPECT_LE(operationsOf(grammar).counted, 2 * entries + scaling);
  const std::size_t csr = 3 * entries + 4 * (rows.row_offsets.size());
  EXPECT_LE(bytesInMemory(grammar), csr + 8 * grammar.groups.size() + 4 * grammar.level_ends.size() +
                                        grammar.tiles.size() * sizeof(formats::SumTile));
}

INSTANTIATE_TEST_SUITE_P(Kinds, Compressed, testing::ValuesIn(kCases),
                         [](const auto& kind) { return kind.param.name; });

TEST(Compression, SharesWhatRowsHaveInCommon) {
  const PixelRows rows = ballRows(300, 16, 8, 2);
  const SumGrammar grammar = compress(rows.view());
  EXPECT_LT(static_cast<double>(operationsOf(grammar).counted),
            0.5 * 2 * static_cast<double>(rows.columns.size()));
  EXPECT_LT(formats::encodedBytes(formats::encodeSumGrammar(grammar)), rows.columns.size());
}

// Forty bundles of equal rows, none with a texel in the code of another's: 40,000 leaves, of which no table holds all. Each bundle is a
// sum of 1,000 leaves that its 20 rows have in common, a twentieth of their entries.
TEST(Compression, CutsTilesWhoseTablesWouldBeTooLarge) {
  PixelRows rows = emptyRows(32, 1, 15);
  for (int bundle = 0; bundle < 40; ++bundle)
    for (int row = 0; row < 20; ++row) {
      for (int i = 0; i < 1000; ++i) rows.columns.push_back(static_cast<std::uint16_t>(100 * bundle + i));
      rows.codes.insert(rows.codes.end(), 1000, static_cast<std::uint8_t>(1 + bundle));
      rows.row_offsets.push_back(rows.columns.size());
    }
  const SumGrammar grammar = compress(rows.view());
  EXPECT_GE(grammar.tileCount(), 2U);
  EXPECT_EQ(reconstructionErrors(grammar, rows.view()), 0U);
  EXPECT_LE(operationsOf(grammar).executed, 2 * rows.columns.size() / 20);
}

TEST(Compression, RefusesRowsThatAreNotSorted) {
  PixelRows rows = ballRows(2, 8, 4, 2);
  std::swap(rows.columns[3], rows.columns[4]);
  EXPECT_THROW(compress(rows.view()), std::invalid_argument);
  rows = ballRows(2, 8, 4, 2);
  rows.codes[5] = 0;
  EXPECT_THROW(compress(rows.view()), std::invalid_argument);
}

// Any byte of any tensor, with a digest that fits and without.
TEST(SumGrammarFile, BrokenOnesAreRefusedOrHarmless) {
  const PixelRows rows = ballRows(8, 8, 4, 2);
  const formats::TensorFile whole = formats::encodeSumGrammar(compress(rows.view()));
  for (const auto& [name, tensor] : whole.tensors) {
    formats::TensorFile broken = whole;
    formats::Bytes bytes(tensor.data.data(), tensor.data.data() + tensor.data.size());
    bytes[bytes.size() / 2] ^= std::byte{0x15};
    broken.tensors[name] = {formats::ElementType::kUint8, {bytes.size()}, bytes};
    try {
      formats::decodeSumGrammar(broken, "broken.safetensors");
      FAIL() << name << " was read";
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), ExitStatus::kBadInput);
      EXPECT_THAT(error.what(), testing::HasSubstr("broken.safetensors"));
    }
    broken = whole;
    broken.tensors.erase(name);
    EXPECT_THROW(formats::decodeSumGrammar(broken, "broken"), Error) << name;
  }
  for (const char* key : {"cube_side", "local_side", "subsamples", "rows"}) {
    formats::TensorFile broken = whole;
    broken.metadata[key] = "-3";
    EXPECT_THROW(formats::decodeSumGrammar(broken, "broken"), Error) << key;
  }
  formats::TensorFile smaller = whole;
  smaller.metadata["rows"] = "5";
  EXPECT_THROW(formats::decodeSumGrammar(smaller, "broken"), Error);
  smaller = whole;
  smaller.metadata["cube_side"] = "2";
  EXPECT_THROW(formats::decodeSumGrammar(smaller, "broken"), Error);
}

TEST(Tolerance, IsKept) {
  const PixelRows rows = ballRows(60, 32, 8, 2);
  double operations = 1e30;
  for (const double tolerance : {0.0, 0.02, 0.1, 0.4}) {
    const TolerantRows changed = withinTolerance(rows.view(), tolerance);
    EXPECT_LE(changed.figures.largest_error, tolerance);
    EXPECT_LE(changed.figures.white_sky_error, changed.figures.largest_error + 1e-12);
    double largest = 0;
    const PixelCodes before = rows.view(), after = changed.rows.view();
    for (std::size_t row = 0; row < before.rowCount(); ++row) {
      std::map<std::uint16_t, int> change;
      for (std::uint64_t i = before.row_offsets[row]; i < before.row_offsets[row + 1]; ++i)
        change[before.columns[i]] -= before.codes[i];
      for (std::uint64_t i = after.row_offsets[row]; i < after.row_offsets[row + 1]; ++i)
        change[after.columns[i]] += after.codes[i];
      double error = 0;
      for (const auto& [column, code] : change)
        error += std::abs(code) / 4.0 * transport::cubeTexelSolidAngle(column % 32, column / 32 % 32, 32);
      largest = std::max(largest, error / (2 * M_PI / 64));
    }
    // A texel may be changed twice, of which the second may take the first back.
    EXPECT_LE(largest, changed.figures.largest_error + 1e-9);
    EXPECT_EQ(sameRows(changed.rows, rows), tolerance == 0);
    const auto counted = static_cast<double>(operationsOf(compress(after)).counted);
    EXPECT_LT(counted, operations) << tolerance;
    operations = counted;
  }
}

}  // namespace
}  // namespace bakelight::compression
