#include "formats/pixel_transfer.h"

#include <cstring>
#include <numeric>
#include <stdexcept>

namespace bakelight::formats {
namespace {

template <class T>
std::span<const T> valuesOf(const IntegerArray& integers) {
  return {reinterpret_cast<const T*>(integers.data.data()), integers.count()};
}

template <class T>
SharedBytes bytesOf(std::span<const T> values) {
  const auto bytes = std::as_bytes(values);
  return Bytes(bytes.begin(), bytes.end());
}

// Where a value is not 0 to `end`, as text; empty if there is none.
template <class T>
std::string strayValue(const IntegerArray& integers, std::size_t first, std::size_t end) {
  const std::span<const T> values = valuesOf<T>(integers);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] < first || values[i] >= end)
      return "value " + std::to_string(i) + " is " + std::to_string(values[i]);
  return "";
}

std::uint64_t entriesOf(const IntegerArray& row_lengths) {
  const auto lengths = valuesOf<std::uint16_t>(row_lengths);
  return std::accumulate(lengths.begin(), lengths.end(), std::uint64_t{0});
}

}  // namespace

void PixelTransfer::describe(FieldVisitor& fields) {
  fields.constant("frame", "local");
  fields.constant("cosine", "outside");
  fields.integer("cubeSide", cube_side, {1, kMostCubeSide});
  fields.integer("localSide", local_side, {1, kMostLocalSide});
  fields.integer("subsamples", subsamples, {1, kMostSubsamples});
  fields.number("creaseAngle", crease_angle, {0, 180});
  fields.tangents("tangents", tangents);
  fields.integers("rowLengths", row_lengths, row_lengths.count());
  fields.require(row_lengths.count() % cells() == 0, "rowLengths",
                 "it has " + std::to_string(row_lengths.count()) + " rows",
                 "a multiple of " + std::to_string(cells()) + ", the cells of a hemisphere", "");
  fields.indices("blocks", blocks, blockCount());
  const std::uint64_t entries = entriesOf(row_lengths);
  fields.integers("columns", columns, entries);
  fields.integers("codes", codes, entries);
  const std::size_t texels = 6 * static_cast<std::size_t>(cube_side) * cube_side;
  const std::string stray_column = strayValue<std::uint16_t>(columns, 0, texels);
  fields.require(stray_column.empty(), "columns", stray_column, "below " + std::to_string(texels), "");
  const std::size_t most = static_cast<std::size_t>(subsamples) * subsamples;
  const std::string stray_code = strayValue<std::uint8_t>(codes, 1, most + 1);
  fields.require(stray_code.empty(), "codes", stray_code, "1 to " + std::to_string(most), "");
}

PixelTransferRows::PixelTransferRows(const PixelTransfer& transfer) : transfer_(transfer) {
  transfer_.tangents.clear();
  transfer_.blocks.clear();
  const auto lengths = valuesOf<std::uint16_t>(transfer.row_lengths);
  row_offsets_.reserve(lengths.size() + 1);
  row_offsets_.push_back(0);
  for (const std::uint16_t length : lengths) row_offsets_.push_back(row_offsets_.back() + length);
  if (row_offsets_.back() != transfer.columns.count() || row_offsets_.back() != transfer.codes.count() ||
      lengths.size() % transfer.cells() != 0)
    throw std::invalid_argument("rows of transfer in a pixel basis do not fit their lengths");
}

PixelCodes PixelTransferRows::view() const {
  return {transfer_.cube_side,
          transfer_.local_side,
          transfer_.subsamples,
          row_offsets_,
          valuesOf<std::uint16_t>(transfer_.columns),
          valuesOf<std::uint8_t>(transfer_.codes)};
}

PixelTransfer pixelTransferOf(const PixelCodes& codes, std::vector<Float4> tangents) {
  PixelTransfer transfer;
  transfer.cube_side = codes.cube_side;
  transfer.local_side = codes.local_side;
  transfer.subsamples = codes.subsamples;
  if (codes.rowCount() != tangents.size() * transfer.cells())
    throw std::invalid_argument("there must be a block of rows for each tangent");
  transfer.blocks.resize(tangents.size());
  std::iota(transfer.blocks.begin(), transfer.blocks.end(), 0U);
  transfer.tangents = std::move(tangents);
  std::vector<std::uint16_t> lengths(codes.rowCount());
  for (std::size_t row = 0; row < lengths.size(); ++row)
    lengths[row] = static_cast<std::uint16_t>(codes.row_offsets[row + 1] - codes.row_offsets[row]);
  transfer.row_lengths.data = bytesOf(std::span<const std::uint16_t>(lengths));
  transfer.columns.data = bytesOf(codes.columns);
  transfer.codes.data = bytesOf(codes.codes);
  return transfer;
}

}  // namespace bakelight::formats
