#include "transport/form_factors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "transport/random.h"

namespace bakelight::transport {

namespace {

constexpr std::uint32_t kNoSide = ~std::uint32_t{0};
constexpr float kLargestCode = 65535;

}  // namespace

SeenSums::SeenSums(std::size_t most_sides)
    : slots_(std::bit_ceil(std::max<std::size_t>(2 * most_sides, 16)), SeenVertex{kNoSide, 0}),
      shift_(32 - std::countr_zero(slots_.size())) {}

void SeenSums::add(std::uint32_t side, float weight) {
  // Fibonacci hashing: neighbours, which most sides of a row are, fall far apart.
  std::size_t slot = (side * 2654435769U) >> shift_;
  while (slots_[slot].side != side) {
    if (slots_[slot].side == kNoSide) {
      slots_[slot].side = side;
      used_.push_back(static_cast<std::uint32_t>(slot));
      break;
    }
    slot = (slot + 1) & (slots_.size() - 1);
  }
  slots_[slot].weight += weight;
}

std::vector<SeenVertex> SeenSums::take() {
  std::vector<SeenVertex> seen;
  seen.reserve(used_.size());
  for (const std::uint32_t slot : used_) {
    seen.push_back(slots_[slot]);
    slots_[slot] = {kNoSide, 0};
  }
  used_.clear();
  std::sort(seen.begin(), seen.end(),
            [](const SeenVertex& a, const SeenVertex& b) { return a.side < b.side; });
  return seen;
}

namespace {

struct SmallShares {
  double sum = 0;
  std::size_t present = 0;
  std::size_t left = 0;  // after they were put together
};

SmallShares smallShares(std::span<const SeenVertex> row, float threshold) {
  SmallShares small;
  for (const SeenVertex& seen : row)
    if (seen.weight < threshold) small.sum += seen.weight, ++small.present;
  // Not more than fit at the threshold's size, so that none falls to a side twice.
  small.left =
      std::min(small.present, static_cast<std::size_t>(std::max(1.0, std::floor(small.sum / threshold))));
  return small;
}

// Where in its first step the sampling of a row begins, 0–1: elsewhere in each, or sides that come first in
// all rows would always lose.
double startOf(std::span<const SeenVertex> row) {
  std::uint64_t key = row.size();
  for (const SeenVertex& seen : row)
    key = key * 0x9e3779b97f4a7c15U +
          (std::uint64_t{seen.side} << 32 | std::bit_cast<std::uint32_t>(seen.weight));
  return static_cast<double>(transport::scrambled(key) >> 11) * 0x1p-53;
}

}  // namespace

void putSmallTogether(std::vector<SeenVertex>& row, float threshold) {
  const SmallShares small = smallShares(row, threshold);
  if (small.present <= small.left) return;
  const double size = small.sum / static_cast<double>(small.left);
  const double start = startOf(row);
  double passed = 0;
  std::size_t given = 0, end = 0;
  for (const SeenVertex seen : row) {
    if (seen.weight >= threshold) {
      row[end++] = seen;
      continue;
    }
    passed += seen.weight;
    if (given < small.left && passed > (static_cast<double>(given) + start) * size) {
      row[end++] = {seen.side, static_cast<float>(size)};
      ++given;
    }
  }
  row.resize(end);
}

std::size_t countPutTogether(std::span<const SeenVertex> row, float threshold) {
  const SmallShares small = smallShares(row, threshold);
  return row.size() - small.present + small.left;
}

std::span<const float> FormFactors::Block::weightsOf(std::size_t row, std::vector<float>& decoded) const {
  const std::uint32_t begin = row_begin[row], count = row_begin[row + 1] - begin;
  if (units.empty()) return std::span(weights).subspan(begin, count);
  decoded.resize(count);
  for (std::uint32_t k = 0; k < count; ++k) decoded[k] = static_cast<float>(codes[begin + k]) * units[row];
  return decoded;
}

namespace {

// Appends codes and their unit. The unit is such that the row keeps its sum.
void encode(std::span<const SeenVertex> row, FormFactors::Block& block) {
  float largest = 0;
  double sum = 0, code_sum = 0;
  for (const SeenVertex& seen : row) largest = std::max(largest, seen.weight), sum += seen.weight;
  for (const SeenVertex& seen : row) {
    const float code = std::round(seen.weight / largest * kLargestCode);
    block.codes.push_back(static_cast<std::uint16_t>(code));
    code_sum += code;
  }
  block.units.push_back(code_sum > 0 ? static_cast<float>(sum / code_sum) : 0.0F);
}

}  // namespace

FormFactors::Block FormFactors::packed(std::span<const std::vector<SeenVertex>> rows) const {
  std::vector<std::vector<SeenVertex>> thinned;
  if (storage_.threshold > 0) {
    thinned.assign(rows.begin(), rows.end());
    for (auto& row : thinned) putSmallTogether(row, storage_.threshold);
    rows = thinned;
  }
  std::size_t count = 0;
  for (const auto& row : rows) count += row.size();
  Block block;
  block.row_begin.reserve(rows.size() + 1);
  block.columns.reserve(count);
  if (storage_.exact)
    block.weights.reserve(count);
  else
    block.codes.reserve(count), block.units.reserve(rows.size());
  for (const auto& row : rows) {
    for (const SeenVertex& seen : row) block.columns.push_back(seen.side);
    if (storage_.exact)
      for (const SeenVertex& seen : row) block.weights.push_back(seen.weight);
    else
      encode(row, block);
    block.row_begin.push_back(static_cast<std::uint32_t>(block.columns.size()));
  }
  return block;
}

void FormFactors::append(Block block) {
  if (block.rowCount() == 0) return;
  first_rows_.push_back(rowCount());
  blocks_.push_back(std::move(block));
}

void FormFactors::append(FormFactors&& next) {
  for (Block& block : next.blocks_) append(std::move(block));
  next.blocks_.clear(), next.first_rows_.clear();
}

std::size_t FormFactors::blockOf(std::size_t row) const {
  return static_cast<std::size_t>(std::upper_bound(first_rows_.begin(), first_rows_.end(), row) -
                                  first_rows_.begin()) -
         1;
}

std::vector<SeenVertex> FormFactors::row(std::size_t row) const {
  const std::size_t b = blockOf(row);
  std::vector<float> decoded;
  const auto columns = blocks_[b].columnsOf(row - first_rows_[b]);
  const auto weights = blocks_[b].weightsOf(row - first_rows_[b], decoded);
  std::vector<SeenVertex> seen(columns.size());
  for (std::size_t k = 0; k < seen.size(); ++k) seen[k] = {columns[k], weights[k]};
  return seen;
}

void FormFactors::replace(std::size_t row, std::vector<SeenVertex> seen) {
  const std::size_t b = blockOf(row), local = row - first_rows_[b];
  Block& block = blocks_[b];
  const Block own = packed({&seen, 1});
  const auto at = [&](auto& values) { return values.begin() + block.row_begin[local]; };
  const auto splice = [&](auto& values, const auto& others) {
    values.erase(at(values), values.begin() + block.row_begin[local + 1]);
    values.insert(at(values), others.begin(), others.end());
  };
  splice(block.columns, own.columns);
  if (storage_.exact)
    splice(block.weights, own.weights);
  else
    splice(block.codes, own.codes), block.units[local] = own.units[0];
  const auto grown =
      static_cast<std::uint32_t>(own.columns.size()) - (block.row_begin[local + 1] - block.row_begin[local]);
  for (std::size_t r = local + 1; r < block.row_begin.size(); ++r) block.row_begin[r] += grown;
}

void FormFactors::renumber(std::span<const std::uint32_t> row_of_side) {
  tbb::parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t b) {
    for (std::uint32_t& column : blocks_[b].columns) column = row_of_side[column];
  });
}

std::uint64_t FormFactors::shareCount() const {
  std::uint64_t count = 0;
  for (const Block& block : blocks_) count += block.columns.size();
  return count;
}

std::size_t FormFactors::bytes() const {
  std::size_t bytes = 0;
  for (const Block& block : blocks_)
    bytes += sizeof(Block) + 4 * (block.row_begin.capacity() + block.columns.capacity()) +
             4 * (block.weights.capacity() + block.units.capacity()) + 2 * block.codes.capacity();
  return bytes;
}

}  // namespace bakelight::transport
