#include "tools/bicluster/transfer_rows.h"

#include <charconv>
#include <string>

#include "formats/error.h"

namespace bakelight::bicluster {
namespace {

constexpr const char* kRemedy = "make it with transfer and \"basis\": \"pixel\"";

int sizeOf(const formats::TensorFile& file, const std::string& key, int most, const std::string& name) {
  const std::string& text = file.requireMetadata(key, name);
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 1 || value > most)
    throw badInput({name, "metadata " + key, ""}, "\"" + text + "\" is out of range",
                   "1 to " + std::to_string(most), kRemedy);
  return value;
}

void checkRow(const formats::PixelCodes& codes, std::size_t row, const std::string& name) {
  const auto fail = [&](const std::string& tensor, const std::string& what, const std::string& expected) {
    throw badInput({name, "tensor " + tensor + ", row " + std::to_string(row), ""}, what, expected, kRemedy);
  };
  const std::uint64_t begin = codes.row_offsets[row], end = codes.row_offsets[row + 1];
  if (begin > end || end > codes.columns.size())
    fail("row_offsets", "it ends before it begins, or beyond the entries", "offsets that grow");
  const int full = codes.subsamples * codes.subsamples;
  for (std::uint64_t i = begin; i < end; ++i) {
    if (codes.columns[i] >= codes.columnCount() || (i > begin && codes.columns[i - 1] >= codes.columns[i]))
      fail("columns",
           "column " + std::to_string(codes.columns[i]) +
               " is beyond the cube map or not after the one before",
           "ascending columns below " + std::to_string(codes.columnCount()));
    if (codes.codes[i] < 1 || codes.codes[i] > full)
      fail("codes", "code " + std::to_string(codes.codes[i]), "1 to " + std::to_string(full));
  }
}

}  // namespace

TransferRows readTransferRows(const std::filesystem::path& path) {
  TransferRows read{formats::readSafetensors(path), {}};
  const std::string name = path.string();
  if (read.file.requireMetadata("technique", name) != "pixel")
    throw badInput({name, "metadata technique", ""}, "it is no transfer in a pixel basis", "technique pixel",
                   kRemedy);
  formats::PixelCodes& codes = read.codes;
  codes.cube_side = sizeOf(read.file, "cube_side", formats::kMostCubeSide, name);
  codes.local_side = sizeOf(read.file, "local_side", formats::kMostLocalSide, name);
  codes.subsamples = sizeOf(read.file, "subsamples", formats::kMostSubsamples, name);
  codes.row_offsets =
      read.file.require("row_offsets", formats::ElementType::kInt64, 1, name).as<std::uint64_t>();
  codes.columns = read.file.require("columns", formats::ElementType::kUint16, 1, name).as<std::uint16_t>();
  codes.codes = read.file.require("codes", formats::ElementType::kUint8, 1, name).as<std::uint8_t>();
  if (codes.row_offsets.empty() || codes.row_offsets[0] != 0 ||
      codes.row_offsets.back() != codes.columns.size() || codes.columns.size() != codes.codes.size())
    throw badInput({name, "tensor row_offsets", ""}, "it does not fit the number of columns and codes",
                   "0 to the number of entries", kRemedy);
  if (codes.rowCount() % static_cast<std::size_t>(codes.local_side * codes.local_side) != 0)
    throw badInput({name, "tensor row_offsets", ""}, std::to_string(codes.rowCount()) + " rows",
                   "local_side² rows a vertex", kRemedy);
  for (std::size_t row = 0; row < codes.rowCount(); ++row) checkRow(codes, row, name);
  return read;
}

}  // namespace bakelight::bicluster
