#include "compression/wavelets_4d.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <stdexcept>

#include "compression/quantized.h"
#include "formats/symbol_code.h"

namespace bakelight::compression {
namespace {

constexpr int kVertexDepth = std::countr_zero(kBlockVertices);
constexpr float kRoot = 0.70710678F;

int cellDepth(int local_side) {
  return std::has_single_bit(static_cast<unsigned>(local_side))
             ? std::countr_zero(static_cast<unsigned>(local_side))
             : 0;
}

// A wavelet of light in a block of vertices: where its coefficients lie, which begin at `begin` and end where the next begin.
struct Column {
  std::uint16_t wavelet = 0;
  std::uint8_t vertex_depth = 0, cell_depth = 0;
  std::uint32_t begin = 0;
};

// Positions are vertex · cells + cell, each in the order of its wavelets, means first.
template <class Value>
struct Block {
  std::vector<Column> columns;
  std::vector<std::uint16_t> positions;
  std::vector<Value> values;

  std::size_t endOf(std::size_t column) const {
    return column + 1 < columns.size() ? columns[column + 1].begin : positions.size();
  }
};

struct Sizes {
  int local_side;
  std::size_t cells, vertices;
  std::size_t blockCount() const { return (vertices + kBlockVertices - 1) / kBlockVertices; }
};

// One level of the first `count` values, `stride` apart.
void haarStep(float* values, std::size_t count, std::size_t stride, float* buffer) {
  for (std::size_t i = 0; i < count / 2; ++i) {
    const float a = values[2 * i * stride], b = values[(2 * i + 1) * stride];
    buffer[i] = (a + b) * kRoot;
    buffer[count / 2 + i] = (a - b) * kRoot;
  }
  for (std::size_t i = 0; i < count; ++i) values[i * stride] = buffer[i];
}

class BlockTransform {
 public:
  BlockTransform(const WaveletRows& rows, const Sizes& sizes, std::span<const std::uint32_t> order,
                 std::span<const float> weights)
      : rows_(rows), sizes_(sizes), order_(order), weights_(weights) {}

  // `threshold` is the price of a coefficient.
  Block<float> transform(std::size_t block, float threshold) {
    gather(block);
    Block<float> result;
    for (std::size_t begin = 0, end = 0; begin < entries_.size(); begin = end) {
      while (end < entries_.size() && entries_[end].wavelet == entries_[begin].wavelet) ++end;
      Column column{entries_[begin].wavelet, 0, 0, static_cast<std::uint32_t>(result.positions.size())};
      const float least = threshold / weights_[column.wavelet];
      price_ = least * least;
      transformColumn({&entries_[begin], &entries_[begin] + (end - begin)}, column);
      for (std::size_t position = 0; position < best_.size(); ++position)
        if (best_[position] != 0) {
          result.positions.push_back(static_cast<std::uint16_t>(position));
          result.values.push_back(best_[position]);
        }
      result.columns.push_back(column);
    }
    return result;
  }

 private:
  struct Entry {
    std::uint16_t wavelet, position;
    float value;
  };

  void gather(std::size_t block) {
    entries_.clear();
    const std::size_t first = block * kBlockVertices,
                      count = std::min(kBlockVertices, sizes_.vertices - first);
    for (std::size_t v = 0; v < count; ++v)
      for (std::size_t cell = 0; cell < sizes_.cells; ++cell) {
        const std::size_t row = order_[first + v] * sizes_.cells + cell;
        for (std::uint64_t i = rows_.offsets[row]; i < rows_.offsets[row + 1]; ++i)
          entries_.push_back(
              {rows_.indices[i], static_cast<std::uint16_t>(v * sizes_.cells + cell), rows_.values[i]});
      }
    std::stable_sort(entries_.begin(), entries_.end(),
                     [](const Entry& a, const Entry& b) { return a.wavelet < b.wavelet; });
  }

  double cost(float value) const { return std::min(double{value} * value, double{price_}); }

  // Σ cost over `count` vertices of the cells that are used.
  double costOf(std::size_t first, std::size_t count) const {
    double sum = 0;
    for (std::size_t v = first; v < first + count; ++v)
      for (const std::uint16_t cell : used_) sum += cost(dense_[v * sizes_.cells + cell]);
    return sum;
  }

  void transformColumn(std::span<const Entry> entries, Column& column) {
    dense_.assign(kBlockVertices * sizes_.cells, 0);
    is_used_.assign(sizes_.cells, 0);
    used_.clear();
    for (const Entry& entry : entries) {
      dense_[entry.position] = entry.value;
      const std::size_t cell = entry.position % sizes_.cells;
      if (is_used_[cell] == 0) used_.push_back(static_cast<std::uint16_t>(cell));
      is_used_[cell] = 1;
    }
    best_ = dense_;
    double least = costOf(0, kBlockVertices), details = 0;
    for (int depth = 1; depth <= kVertexDepth; ++depth) {
      const std::size_t count = kBlockVertices >> (depth - 1);
      for (const std::uint16_t cell : used_) haarStep(&dense_[cell], count, sizes_.cells, buffer_.data());
      details += costOf(count / 2, count / 2);
      if (const double now = details + costOf(0, count / 2); now < least) {
        least = now;
        best_ = dense_;
        column.vertex_depth = static_cast<std::uint8_t>(depth);
      }
    }
    transformCells(least, column);
  }

  void transformCells(double least, Column& column) {
    if (used_.size() < 2) return;  // a cell alone has no neighbors to share with
    dense_ = best_;
    std::array<std::uint8_t, kBlockVertices> empty;
    for (std::size_t v = 0; v < kBlockVertices; ++v)
      empty[v] = std::all_of(used_.begin(), used_.end(),
                             [&](std::uint16_t cell) { return dense_[v * sizes_.cells + cell] == 0; });
    for (int depth = 1; depth <= cellDepth(sizes_.local_side); ++depth) {
      const std::size_t count = static_cast<std::size_t>(sizes_.local_side) >> (depth - 1);
      double sum = 0;
      for (std::size_t v = 0; v < kBlockVertices && sum < least; ++v) {
        if (empty[v] != 0) continue;
        float* cells = &dense_[v * sizes_.cells];
        for (std::size_t row = 0; row < count; ++row)
          haarStep(cells + row * sizes_.local_side, count, 1, buffer_.data());
        for (std::size_t at = 0; at < count; ++at)
          haarStep(cells + at, count, sizes_.local_side, buffer_.data());
        for (std::size_t cell = 0; cell < sizes_.cells; ++cell) sum += cost(cells[cell]);
      }
      if (sum >= least) break;  // deeper ones hardly ever gain what this one lost
      least = sum;
      best_ = dense_;
      column.cell_depth = static_cast<std::uint8_t>(depth);
    }
  }

  const WaveletRows& rows_;
  const Sizes sizes_;
  std::span<const std::uint32_t> order_;
  std::span<const float> weights_;
  float price_ = 0;
  std::vector<Entry> entries_;
  std::vector<float> dense_, best_;
  std::vector<std::uint8_t> is_used_;
  std::vector<std::uint16_t> used_;  // cells in which anything is
  std::array<float, 1024> buffer_{};
};

struct KeptBlocks {
  Sizes sizes;
  int cube_side = 32;
  float step = 1;
  std::vector<std::uint32_t> order;
  std::vector<Block<std::int16_t>> blocks;

  std::size_t coefficientCount() const {
    std::size_t sum = 0;
    for (const auto& block : blocks) sum += block.positions.size();
    return sum;
  }

  std::uint64_t bytes() const {
    std::vector<std::uint32_t> counts, wavelets, depths, lengths, positions, values;
    for (const auto& block : blocks) {
      counts.push_back(static_cast<std::uint32_t>(block.columns.size()));
      for (std::size_t c = 0; c < block.columns.size(); ++c) {
        const Column& column = block.columns[c];
        wavelets.push_back(c == 0 ? column.wavelet : column.wavelet - block.columns[c - 1].wavelet - 1U);
        depths.push_back(column.vertex_depth * 16U + column.cell_depth);
        lengths.push_back(static_cast<std::uint32_t>(block.endOf(c) - column.begin) - 1);
        for (std::size_t i = column.begin; i < block.endOf(c); ++i) {
          positions.push_back(i == column.begin ? block.positions[i]
                                                : block.positions[i] - block.positions[i - 1] - 1U);
          values.push_back(formats::symbolOf(block.values[i]));
        }
      }
    }
    std::uint64_t sum = 0;
    for (const auto& stream : {counts, wavelets, depths, lengths, positions, values})
      sum += formats::encodeSymbols(stream).size();
    return sum;
  }
};

KeptBlocks kept(const std::vector<Block<float>>& blocks, std::span<const float> weights,
                const Quantizer& quantizer) {
  KeptBlocks result;
  result.step = quantizer.step;
  result.blocks.resize(blocks.size());
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
    const Block<float>& from = blocks[b];
    Block<std::int16_t>& to = result.blocks[b];
    for (std::size_t c = 0; c < from.columns.size(); ++c) {
      Column column = from.columns[c];
      column.begin = static_cast<std::uint32_t>(to.positions.size());
      for (std::size_t i = from.columns[c].begin; i < from.endOf(c); ++i)
        if (const std::int32_t multiple = quantizer.quantized(from.values[i], weights[column.wavelet]);
            multiple != 0) {
          to.positions.push_back(from.positions[i]);
          to.values.push_back(static_cast<std::int16_t>(multiple));
        }
      if (to.positions.size() > column.begin) to.columns.push_back(column);
    }
  });
  return result;
}

// Σ (weight · difference)².
double squaredError(const std::vector<Block<float>>& blocks, std::span<const float> weights,
                    const Quantizer& quantizer) {
  double sum = 0;
  for (const auto& block : blocks)
    for (std::size_t c = 0; c < block.columns.size(); ++c) {
      const float weight = weights[block.columns[c].wavelet];
      for (std::size_t i = block.columns[c].begin; i < block.endOf(c); ++i) {
        const double difference =
            weight * (block.values[i] - quantizer.value(quantizer.quantized(block.values[i], weight)));
        sum += difference * difference;
      }
    }
  return sum;
}

// Values of a block by depths, from which L* is put together: what is deeper is taken back a level and added to what is less deep.
class BlockInverse {
 public:
  explicit BlockInverse(const Sizes& sizes)
      : sizes_(sizes),
        depths_(cellDepth(sizes.local_side) + 1),
        values_((kVertexDepth + 1) * depths_),
        next_(std::max<std::size_t>(kBlockVertices, sizes.cells)) {}

  void add(const Block<std::int16_t>& block, const std::vector<Radiance4>& light) {
    for (auto& values : values_) values.clear();
    for (std::size_t c = 0; c < block.columns.size(); ++c) {
      const Column& column = block.columns[c];
      std::vector<Radiance4>& values = of(column.vertex_depth, column.cell_depth);
      const Radiance4 factor = light[column.wavelet];
      for (std::size_t i = column.begin; i < block.endOf(c); ++i)
        values[block.positions[i]] += factor * static_cast<float>(block.values[i]);
    }
  }

  // By vertex, then cell; returns the operations on a channel that putting together takes.
  std::uint64_t result(std::span<Radiance4> out) {
    std::uint64_t operations = 0;
    for (int vertex_depth = kVertexDepth; vertex_depth >= 0; --vertex_depth) {
      for (int depth = depths_ - 1; depth > 0; --depth) operations += undoCells(vertex_depth, depth);
      if (vertex_depth > 0) operations += undoVertices(vertex_depth);
    }
    const std::vector<Radiance4>& values = values_[0];
    if (values.empty())
      std::fill(out.begin(), out.end(), Radiance4::Zero());
    else
      std::copy_n(values.begin(), out.size(), out.begin());
    return operations;
  }

 private:
  std::vector<Radiance4>& of(int vertex_depth, int cell_depth) {
    std::vector<Radiance4>& values = values_[vertex_depth * depths_ + cell_depth];
    if (values.empty()) values.assign(kBlockVertices * sizes_.cells, Radiance4::Zero());
    return values;
  }
  bool isEmpty(int vertex_depth, int cell_depth) const {
    return values_[vertex_depth * depths_ + cell_depth].empty();
  }

  void undoStep(Radiance4* values, std::size_t count, std::size_t stride) {
    for (std::size_t i = 0; i < count / 2; ++i) {
      const Radiance4 mean = values[i * stride], detail = values[(count / 2 + i) * stride];
      next_[2 * i] = (mean + detail) * kRoot;
      next_[2 * i + 1] = (mean - detail) * kRoot;
    }
    for (std::size_t i = 0; i < count; ++i) values[i * stride] = next_[i];
  }

  std::uint64_t addTo(std::vector<Radiance4>& to, const std::vector<Radiance4>& from) {
    for (std::size_t i = 0; i < to.size(); ++i) to[i] += from[i];
    return to.size();
  }

  std::uint64_t undoCells(int vertex_depth, int depth) {
    if (isEmpty(vertex_depth, depth)) return 0;
    std::vector<Radiance4>& values = of(vertex_depth, depth);
    const std::size_t side = sizes_.local_side, count = side >> (depth - 1);
    for (std::size_t v = 0; v < kBlockVertices; ++v) {
      Radiance4* cells = &values[v * sizes_.cells];
      for (std::size_t at = 0; at < count; ++at) undoStep(cells + at, count, side);
      for (std::size_t row = 0; row < count; ++row) undoStep(cells + row * side, count, 1);
    }
    return 4 * kBlockVertices * count * count + addTo(of(vertex_depth, depth - 1), values);
  }

  std::uint64_t undoVertices(int depth) {
    if (isEmpty(depth, 0)) return 0;
    std::vector<Radiance4>& values = of(depth, 0);
    const std::size_t count = kBlockVertices >> (depth - 1);
    for (std::size_t cell = 0; cell < sizes_.cells; ++cell) undoStep(&values[cell], count, sizes_.cells);
    return 2 * count * sizes_.cells + addTo(of(depth - 1, 0), values);
  }

  Sizes sizes_;
  int depths_;
  std::vector<std::vector<Radiance4>>
      values_;  // by vertex depth, then cell depth; empty where nothing has it
  std::vector<Radiance4> next_;
};

std::uint64_t multiply(const KeptBlocks& transfer, std::span<const Radiance4> light,
                       std::span<Radiance4> values) {
  std::vector<Radiance4> transformed(light.begin(), light.end());
  forwardHaar(transfer.cube_side, transformed);
  for (Radiance4& value : transformed) value *= transfer.step;
  const std::size_t cells = transfer.sizes.cells;
  std::vector<std::uint64_t> operations(transfer.blocks.size());
  tbb::enumerable_thread_specific<BlockInverse> inverses([&] { return BlockInverse(transfer.sizes); });
  tbb::parallel_for(std::size_t{0}, transfer.blocks.size(), [&](std::size_t b) {
    BlockInverse& inverse = inverses.local();
    inverse.add(transfer.blocks[b], transformed);
    std::vector<Radiance4> block(kBlockVertices * cells);
    operations[b] = inverse.result(block) + 2 * transfer.blocks[b].positions.size();
    const std::size_t first = b * kBlockVertices,
                      count = std::min(kBlockVertices, transfer.sizes.vertices - first);
    for (std::size_t v = 0; v < count; ++v)
      std::copy_n(&block[v * cells], cells, values.data() + transfer.order[first + v] * cells);
  });
  return std::accumulate(operations.begin(), operations.end(), std::uint64_t{0});
}

// The blocks b with b % every = 0.
std::vector<Block<float>> transformed(const WaveletRows& rows, const Sizes& sizes,
                                      std::span<const std::uint32_t> order, std::span<const float> weights,
                                      float threshold, std::size_t every = 1) {
  std::vector<Block<float>> blocks((sizes.blockCount() + every - 1) / every);
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
    blocks[block] = BlockTransform(rows, sizes, order, weights).transform(block * every, threshold);
  });
  return blocks;
}

struct Choice {
  Quantizer quantizer;
  int bits = 0;
  double position = 0.5, squared_error = std::numeric_limits<double>::infinity();
};

Choice quantizerWithin(std::uint64_t budget, const std::vector<Block<float>>& blocks,
                       std::span<const float> weights, std::span<const int> tried, double guess) {
  float largest = std::numeric_limits<float>::min(), largest_weight = 0;
  for (const auto& block : blocks)
    for (const float value : block.values) largest = std::max(largest, std::abs(value));
  for (const float weight : weights) largest_weight = std::max(largest_weight, weight);
  // By no more than rows in the basis of all four dimensions can have, so that the same position is the same threshold for all blocks.
  const float largest_weighted = largest_weight * 1024;
  Choice best;
  for (const int bits : tried) {
    const auto at = [&](double position) {
      return Quantizer::of(largest, bits, thresholdAt(position, largest_weighted));
    };
    const Solved solved = solveForBytes(
        [&](double position) { return kept(blocks, weights, at(position)).bytes(); }, budget, guess);
    const double error = squaredError(blocks, weights, at(solved.at));
    if (error < best.squared_error) best = {at(solved.at), bits, solved.at, error};
  }
  return best;
}

}  // namespace

CompressedTransfer wavelets4dWithin(std::uint64_t budget, const WaveletRows& rows, int local_side,
                                    std::span<const std::uint32_t> order) {
  const std::size_t cells = static_cast<std::size_t>(local_side) * local_side;
  const Sizes sizes{local_side, cells, rows.rowCount() / cells};
  if (order.size() != sizes.vertices || rows.rowCount() % cells != 0)
    throw std::invalid_argument("4-D wavelets: the order of vertices does not fit the matrix");
  // Depths are chosen for the threshold, and the threshold by what they make of the matrix: a sample of the blocks, from a quarter of what a
  // wavelet over 2 × 2 texels has that one of its texels sees, settles it.
  const std::vector<float> weights = haarAreas(rows.cube_side);
  constexpr std::size_t kSampled = 8;
  const std::size_t every = sizes.blockCount() >= 2 * kSampled ? kSampled : 1;
  float threshold = 0.125F * *std::min_element(weights.begin(), weights.end());
  Choice choice;
  for (int round = 0; round < 2; ++round) {
    const std::vector<Block<float>> sample = transformed(rows, sizes, order, weights, threshold, every);
    const double share = static_cast<double>(sample.size()) /
                         static_cast<double>(std::max<std::size_t>(sizes.blockCount(), 1));
    choice = quantizerWithin(static_cast<std::uint64_t>(share * static_cast<double>(budget)), sample, weights,
                             kQuantizerBits, choice.position);
    threshold = choice.quantizer.threshold;
  }
  const std::vector<Block<float>> blocks = transformed(rows, sizes, order, weights, threshold);
  const std::array bits = {choice.bits};
  choice = quantizerWithin(budget, blocks, weights, bits, choice.position);

  const auto result = std::make_shared<KeptBlocks>(kept(blocks, weights, choice.quantizer));
  result->sizes = sizes;
  result->cube_side = rows.cube_side;
  result->order.assign(order.begin(), order.end());
  CompressedTransfer transfer;
  transfer.name = "wavelets4d";
  transfer.parameters = std::to_string(result->coefficientCount()) + " coefficients of " +
                        std::to_string(choice.bits) + " bits";
  transfer.bytes = result->bytes();
  transfer.value_count = rows.rowCount();
  const std::vector<Radiance4> dark(6 * static_cast<std::size_t>(rows.cube_side) * rows.cube_side,
                                    Radiance4::Zero());
  std::vector<Radiance4> nothing(rows.rowCount());
  transfer.operations = multiply(*result, dark, nothing);
  transfer.multiply = [result](std::span<const Radiance4> light, std::span<Radiance4> values) {
    multiply(*result, light, values);
  };
  return transfer;
}

}  // namespace bakelight::compression
