#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

#include "formats/btf.h"
#include "formats/btf_writer.h"
#include "formats/error.h"
#include "formats/file.h"
#include "tests/unit/btf/btf_maker.h"
#include "transport/btf_factorization.h"

namespace bakelight::formats {
namespace {

using testing::HasSubstr;

std::filesystem::path folder() {
  const std::filesystem::path path = testing::TempDir() + "btf_file_test";
  std::filesystem::create_directories(path);
  return path;
}

double largestDifference(std::span<const float> a, std::span<const float> b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    largest = std::max(largest, static_cast<double>(std::abs(a[i] - b[i])));
  return largest;
}

// By a name.
std::map<std::string, BtfVariant> variants() {
  std::map<std::string, BtfVariant> all;
  for (const int model : {0, 1, 3, 4, 5, 9, 10, 11, 12})
    all["dfmf_model" + std::to_string(model)] = {.color_model = model};
  for (const int scalar : {2, 8})
    all["dfmf_scalar" + std::to_string(scalar)] = {.scalar = scalar, .color_model = 1};
  all["dfmf_transposed"] = {.transposed = true, .color_model = 11};
  for (const std::uint32_t version : {1U, 2U, 4U})
    all["dfmf_meta" + std::to_string(version)] = {.meta_version = version, .cosine = 0};
  all["dfmf_rotations"] = {.rotations = 6};
  for (const char* signature : {"!FMF06FC", "!FMF06FCR", "!FMF12FCER", "!PVF06FC", "!PVF06FCR"}) {
    BtfVariant variant{.signature = signature};
    const std::string name = std::string(signature).substr(1);
    all[name] = variant;
    variant.transposed = true, variant.scalar = 2, variant.rotations = 1;
    all[name + "_transposed"] = variant;
  }
  all["fmf_logarithmic"] = {.signature = "!FMF12FCER", .is_logarithmic = true};
  all["fmf_extension0"] = {.signature = "!FMF12FCER", .extension = 0};
  all["fmf_extension1"] = {.signature = "!FMF12FCER", .is_logarithmic = true, .extension = 1};
  all["bdi"] = {.signature = "!BDIF06R2!", .scalar = 2};
  all["bdi_chunks_of_one_line"] = {.signature = "!BDIF06R2!", .scalar = 2, .rotations = 6, .scan_lines = 1};
  all["bdi_sparse"] = {.signature = "!BDIF06R2!", .scalar = 2, .compression = 2, .missing_texel = 4};
  return all;
}

// Halves of numbers around 1, which PVF's differences are of, too.
double toleranceOf(const BtfVariant& variant) {
  return variant.scalar == 2 ? 5e-4 : 2e-6;
}

std::vector<float> expectedOf(const BtfVariant& variant) {
  MadeBtf made = smallBtf();
  if (variant.missing_texel >= 0)
    made.value = [all = made.value, missing = variant.missing_texel](const auto& view, const auto& light,
                                                                     int texel) {
      return texel == missing ? std::array<double, 3>{} : all(view, light, texel);
    };
  return made.values();
}

TEST(BtfFile, IsReadInEveryLayout) {
  for (const auto& [name, variant] : variants()) {
    const std::filesystem::path path = folder() / (name + ".btf");
    writeFileAtomically(path, BtfMaker(smallBtf(), variant).bytes());
    ASSERT_TRUE(isBtfFile(path)) << name;
    const std::unique_ptr<Btf> btf = openBtf(path);
    EXPECT_LT(largestDifference(decoded(*btf), expectedOf(variant)), toleranceOf(variant)) << name;
    EXPECT_EQ(btf->info().width, 3) << name;
    EXPECT_EQ(btf->info().height, 2) << name;
    EXPECT_EQ(btf->info().views.size(), 3U) << name;
    EXPECT_NEAR(btf->info().lights.at(2).azimuth_rad, 2, 1e-6) << name;
    EXPECT_EQ(btf->info().cosine_inside, variant.meta_version > 1 && variant.cosine != 0) << name;
    EXPECT_EQ(btf->info().measurement_setup, "dome") << name;
    EXPECT_EQ(btf->info().texels_per_mm, 12.5) << name;
    EXPECT_EQ(btf->info().bytes, std::filesystem::file_size(path)) << name;
  }
  EXPECT_THAT(openBtf(folder() / "bdi_sparse.btf")->info().notes, testing::Contains(HasSubstr("1 texels")));
}

TEST(BtfFile, OfTheOldPerViewLayoutIsRead) {
  const std::filesystem::path path = folder() / "old.btf";
  writeFileAtomically(path, BtfMaker(smallBtf(), {.signature = "!PVF06FC", .old_body = true}).bytes());
  EXPECT_LT(largestDifference(decoded(*openBtf(path)), smallBtf().values()), 2e-6);
}

// Made files first: what reads the reader's and the writer's must read those, too.
TEST(BtfFile, IsTheSameToAnotherReader) {
  std::string command = BAKELIGHT_PYTHON " " BAKELIGHT_SOURCE_DIR "/tests/unit/btf/read_btf.py";
  const auto add = [&](const std::filesystem::path& path, const std::vector<float>& expected,
                       double tolerance) {
    const std::string raw = path.string() + ".raw";
    writeFileAtomically(raw, std::as_bytes(std::span(expected)));
    command += " " + std::to_string(tolerance) + " " + path.string() + " " + raw;
  };
  for (const auto& [name, variant] : variants()) {
    const std::filesystem::path path = folder() / ("other_" + name + ".btf");
    writeFileAtomically(path, BtfMaker(smallBtf(), variant).bytes());
    add(path, expectedOf(variant), 4 * toleranceOf(variant));
  }
  const std::unique_ptr<Btf> table = btfOf(smallBtf().info(), smallBtf().values());
  for (const BtfColorModel model : {BtfColorModel::kRgb, BtfColorModel::kYuv, BtfColorModel::kYCoCg,
                                    BtfColorModel::kLogYRelativeUv, BtfColorModel::kLogRgb})
    for (const BtfPrecision precision : {BtfPrecision::kHalf, BtfPrecision::kFloat}) {
      const bool is_half = precision == BtfPrecision::kHalf;
      const std::filesystem::path path =
          folder() / ("written" + std::to_string(static_cast<int>(model)) + (is_half ? "h.btf" : "f.btf"));
      const transport::BtfFactorization factors = transport::factorize(*table, model, 12);
      writeFactorizedBtf(path, table->info(), model, factors.channels, precision);
      add(path, smallBtf().values(), is_half ? 6e-3 : 1e-5);
      EXPECT_LT(largestDifference(decoded(*openBtf(path)), smallBtf().values()), is_half ? 2e-3 : 4e-6);
    }
  writeRawBtf(folder() / "written_raw.btf", *table);
  add(folder() / "written_raw.btf", smallBtf().values(), 5e-4);
  EXPECT_LT(largestDifference(decoded(*openBtf(folder() / "written_raw.btf")), smallBtf().values()), 2.5e-4);
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
}

TEST(BtfFile, KeepsWhatItSaysOfItself) {
  BtfInfo info = smallBtf().info();
  info.cosine_inside = false, info.texels_per_mm = 3, info.measurement_setup = "made",
  info.light_source = "sun";
  const std::unique_ptr<Btf> table = btfOf(info, smallBtf().values());
  const std::filesystem::path path = folder() / "said.btf";
  writeFactorizedBtf(path, info, BtfColorModel::kRgb,
                     transport::factorize(*table, BtfColorModel::kRgb, 3).channels, BtfPrecision::kFloat);
  const std::unique_ptr<Btf> read = openBtf(path);
  EXPECT_FALSE(read->info().cosine_inside);
  EXPECT_EQ(read->info().texels_per_mm, 3);
  EXPECT_EQ(read->info().measurement_setup, "made");
  EXPECT_EQ(read->info().light_source, "sun");
  EXPECT_EQ(read->info().views.size(), info.views.size());
  EXPECT_NEAR(read->info().views[1].polar_rad, 0.5, 1e-7);
}

// A sum of two products of which the second is a tenth: rank 1 leaves that, rank 2 nothing.
TEST(BtfFactorization, LeavesWhatTheSingularValuesSay) {
  MadeBtf made;
  made.views = {{0, 0}, {0.4, 0}}, made.lights = directions81();
  made.width = 20, made.height = 10;
  const auto angle = [](int texel) { return 2 * std::numbers::pi * texel / 200; };
  made.value = [&](const BtfDirection& view, const BtfDirection& light, int texel) {
    const double a =
        view.polar_rad > 0 ? 1 : -1;  // orthogonal over the views, as are the two over the texels
    const double first = std::cos(angle(texel)), second = 0.1 * a * std::sin(angle(texel));
    return std::array<double, 3>{(first + second) * std::cos(light.polar_rad), first, first};
  };
  const std::unique_ptr<Btf> btf = btfOf(made.info(), made.values());
  const transport::BtfFactorization one = transport::factorize(*btf, BtfColorModel::kRgb, 1);
  EXPECT_NEAR(one.relative_errors[0], 0.1 / std::sqrt(1.01), 1e-5);
  EXPECT_LT(one.relative_errors[1], 1e-3);
  const transport::BtfFactorization more = transport::factorize(*btf, BtfColorModel::kRgb, 8);
  EXPECT_EQ(more.channels[0].rank, 2U) << "the rest is rounding";
  EXPECT_EQ(more.channels[1].rank, 1U);
  EXPECT_LT(more.relative_errors[0], 1e-3);
}

TEST(BtfFactorization, GivesTheSameBytesWithAnyNumberOfThreads) {
  MadeBtf made = smallBtf();
  made.width = 40, made.height = 33;  // several blocks
  const std::unique_ptr<Btf> btf = btfOf(made.info(), made.values());
  const auto factors = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return transport::factorize(*btf, BtfColorModel::kLogYRelativeUv, 4).channels;
  };
  const auto one = factors(1), four = factors(4);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(one[c].directions, four[c].directions);
    EXPECT_EQ(one[c].texels, four[c].texels);
  }
}

std::string problemOf(const std::vector<std::byte>& bytes) {
  const std::filesystem::path path = folder() / "wrong.btf";
  std::ofstream(path, std::ios::binary)  // thousands of them: none needs to last
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  try {
    decoded(*openBtf(path));
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    return error.paragraph();
  }
  return "";
}

TEST(BtfFile, RefusesWhatItCannotRead) {
  const auto problem = [](const BtfVariant& variant) {
    return problemOf(BtfMaker(smallBtf(), variant).bytes());
  };
  EXPECT_THAT(problem({.color_model = 2}), HasSubstr("Lab"));
  EXPECT_THAT(problem({.color_model = 7}), HasSubstr("model 7"));
  EXPECT_THAT(problem({.meta_version = 5}), HasSubstr("version 5"));
  EXPECT_THAT(problem({.rotations = 4}), HasSubstr("4 rotations"));
  EXPECT_THAT(problem({.signature = "!FMF12FCER", .extension = 3}), HasSubstr("version 3"));
  EXPECT_THAT(problem({.signature = "!BDIF06R2!", .compression = 1}), HasSubstr("bzip"));
  EXPECT_THAT(problem({.signature = "!BDIF06R2!", .compression = 3}), HasSubstr("compression is 3"));
  EXPECT_THAT(problem({.signature = "!XYZ06FC"}), HasSubstr("does not begin"));
  MadeBtf below = smallBtf();
  below.lights[1].polar_rad = 2;
  EXPECT_THAT(problemOf(BtfMaker(below, {}).bytes()), HasSubstr("light 1"));
  std::vector<std::byte> longer = BtfMaker(smallBtf(), {}).bytes();
  longer.push_back(std::byte{0});
  EXPECT_THAT(problemOf(longer), HasSubstr("1 bytes follow"));
  MadeBtf nan = smallBtf();
  nan.value = [](const auto&, const auto&, int texel) {
    return std::array<double, 3>{1, texel == 4 ? std::nan("") : 1, 1};
  };
  EXPECT_THAT(problemOf(BtfMaker(nan, {.signature = "!BDIF06R2!"}).bytes()), HasSubstr("texel (1, 1)"));
}

// Whatever byte is cut or turned: an error that says so, or other values, and never more memory than the file.
TEST(BtfFile, SurvivesDamage) {
  for (const char* name : {"dfmf_model11", "FMF12FCER", "PVF06FCR", "bdi_sparse", "dfmf_meta4"}) {
    const std::vector<std::byte> bytes = BtfMaker(smallBtf(), variants().at(name)).bytes();
    for (std::size_t size = 0; size < bytes.size(); size += size < 400 ? 3 : 61) {
      const std::string problem =
          problemOf({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)});
      ASSERT_THAT(problem, HasSubstr("offset")) << name << " cut to " << size;
    }
    for (std::size_t at = 0; at < bytes.size(); at += at < 400 ? 2 : 61)
      for (const int flip : {0x01, 0xFF}) {
        std::vector<std::byte> turned = bytes;
        turned[at] ^= static_cast<std::byte>(flip);
        problemOf(turned);
      }
  }
}

}  // namespace
}  // namespace bakelight::formats
