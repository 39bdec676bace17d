#include "formats/pixel_transfer.h"

#include <cstring>
#include <limits>
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

namespace {

void describeSums(FieldVisitor& fields, PixelSums& sums, std::size_t cells) {
  constexpr int kMostBlocks = std::numeric_limits<int>::max();
  fields.integer("blockCount", sums.block_count, {0, kMostBlocks});
  fields.require(sums.block_count * cells < std::numeric_limits<std::uint32_t>::max(), "blockCount",
                 "it has " + std::to_string(sums.block_count * cells) + " rows", "fewer than 2³² − 1", "");
  for (int stream = 0; stream < kSumStreams; ++stream)
    fields.integers(kSumStreamKeys[stream], sums.streams[stream], sums.streams[stream].count());
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
  optionally(fields, "changes", changes, [&](PixelChanges& group) {
    fields.number("tolerance", group.tolerance, {0, 1});
    fields.number("largestError", group.largest_error, {0});
    fields.number("rmsError", group.rms_error, {0});
  });
  optionally(fields, "sums", sums, [&](PixelSums& group) { describeSums(fields, group, cells()); });
  if (!sums) describeRows(fields);
  fields.indices("blocks", blocks, blockCount());
}

void PixelTransfer::describeRows(FieldVisitor& fields) {
  fields.integers("rowLengths", row_lengths, row_lengths.count());
  fields.require(row_lengths.count() % cells() == 0, "rowLengths",
                 "it has " + std::to_string(row_lengths.count()) + " rows",
                 "a multiple of " + std::to_string(cells()) + ", the cells of a hemisphere", "");
  const std::uint64_t entries = entriesOf(row_lengths);
  fields.integers("columns", columns, entries);
  fields.integers("codes", codes, entries);
  const std::string stray_column = strayValue<std::uint16_t>(columns, 0, texels());
  fields.require(stray_column.empty(), "columns", stray_column, "below " + std::to_string(texels()), "");
  const std::size_t most = static_cast<std::size_t>(subsamples) * subsamples;
  const std::string stray_code = strayValue<std::uint8_t>(codes, 1, most + 1);
  fields.require(stray_code.empty(), "codes", stray_code, "1 to " + std::to_string(most), "");
}

PixelTransferRows::PixelTransferRows(const PixelTransfer& transfer) : transfer_(transfer) {
  if (transfer.sums) throw std::invalid_argument("transfer in a pixel basis has sums, not rows");
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

namespace {

void layOut(PixelTransfer& transfer, std::uint64_t rows, std::vector<Float4> tangents) {
  if (rows != tangents.size() * transfer.cells())
    throw std::invalid_argument("there must be a block of rows for each tangent");
  transfer.blocks.resize(tangents.size());
  std::iota(transfer.blocks.begin(), transfer.blocks.end(), 0U);
  transfer.tangents = std::move(tangents);
}

}  // namespace

PixelTransfer pixelTransferOf(const PixelCodes& codes, std::vector<Float4> tangents) {
  PixelTransfer transfer;
  transfer.cube_side = codes.cube_side;
  transfer.local_side = codes.local_side;
  transfer.subsamples = codes.subsamples;
  layOut(transfer, codes.rowCount(), std::move(tangents));
  std::vector<std::uint16_t> lengths(codes.rowCount());
  for (std::size_t row = 0; row < lengths.size(); ++row)
    lengths[row] = static_cast<std::uint16_t>(codes.row_offsets[row + 1] - codes.row_offsets[row]);
  transfer.row_lengths.data = bytesOf(std::span<const std::uint16_t>(lengths));
  transfer.columns.data = bytesOf(codes.columns);
  transfer.codes.data = bytesOf(codes.codes);
  return transfer;
}

PixelTransfer pixelTransferOf(const CodedSums& coded, std::shared_ptr<const SumGrammar> grammar,
                              std::vector<Float4> tangents) {
  PixelTransfer transfer;
  transfer.cube_side = coded.cube_side;
  transfer.local_side = coded.local_side;
  transfer.subsamples = coded.subsamples;
  PixelSums& sums = transfer.sums.emplace();
  sums.block_count = static_cast<int>(tangents.size());
  for (int stream = 0; stream < kSumStreams; ++stream) sums.streams[stream].data = coded.streams[stream];
  sums.grammar = std::move(grammar);
  layOut(transfer, coded.row_count, std::move(tangents));
  return transfer;
}

CodedSums codedSumsOf(const PixelTransfer& transfer) {
  CodedSums coded{transfer.cube_side,
                  transfer.local_side,
                  transfer.subsamples,
                  transfer.sums.value().block_count * transfer.cells(),
                  {}};
  for (int stream = 0; stream < kSumStreams; ++stream)
    coded.streams[stream] = transfer.sums->streams[stream].data;
  return coded;
}

}  // namespace bakelight::formats
