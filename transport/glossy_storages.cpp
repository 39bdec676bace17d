// The three storages behind GlossyTiles.
#include <algorithm>
#include <map>
#include <numeric>
#include <stdexcept>
#include <string>

#include "transport/glossy_tiles.h"
#include "transport/triple_product.h"

namespace bakelight::transport {
namespace {

using formats::EncodedTable;
using formats::Precision;

constexpr std::size_t kTilesPerRange = 8;
// A range of a cluster starts with the cluster's matrices times the light, so it is longer.
constexpr std::size_t kTilesPerClusterRange = 32;

void require(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("GlossyEvaluator: " + what);
}

void checkTable(const EncodedTable& table, std::size_t rows, std::size_t columns, const std::string& what) {
  require(table.rows == rows && table.columns == columns &&
              table.data.size() == rows * columns * formats::bytesPerValue(table.precision),
          what + " does not have the size that the transfer's orders ask for");
  const std::size_t scales = table.precision == Precision::kUint8 ? columns : 0;
  require(table.scale.size() == scales && table.offset.size() == scales, what + " lacks its scales");
}

std::size_t bytesOf(const EncodedTable& table) {
  return table.data.size() + (table.scale.size() + table.offset.size()) * sizeof(float);
}

std::vector<std::uint32_t> identity(std::size_t count) {
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  return order;
}

std::size_t rowLanes(MatrixShape shape) {
  return (shape.rows + kTile - 1) / kTile * kTile;
}

// [c][row lane]: Σ_j offset(i, j) · light[j][c]; the offsets of a channel are a row-major matrix.
AlignedFloats transferOffsets(std::span<const float> offsets, int channels, MatrixShape shape,
                              const AlignedFloats& light) {
  if (offsets.empty()) return {};
  AlignedFloats result(3 * rowLanes(shape));
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < shape.rows; ++i) {
      const float* row = &offsets[((channels == 3 ? c : 0) * shape.rows + i) * shape.columns];
      double sum = 0;
      for (std::size_t j = 0; j < shape.columns; ++j) sum += static_cast<double>(row[j]) * light[j * 3 + c];
      result[c * rowLanes(shape) + i] = static_cast<float>(sum);
    }
  return result;
}

// Calls visit(channel, first colour, last colour): one table for all colours, or one each.
template <class Visit>
void forEachChannel(int channels, const Visit& visit) {
  if (channels == 1) return visit(0, 0, 3);
  for (int channel = 0; channel < channels; ++channel) visit(channel, channel, channel + 1);
}

// The tile's entries as numbers: where they are, or in `scratch`.
const float* decoded(const TileTable& table, std::size_t tile, float* scratch) {
  const TileValues values = table.at(tile);
  if (table.precision == Precision::kFloat32) return reinterpret_cast<const float*>(values.data);
  kernels().decode(values, table.offset.data(), table.entries, scratch);
  return scratch;
}

// One matrix a vertex, read once and multiplied by the row and then by the light.
class MatrixTiles final : public GlossyTiles {
 public:
  MatrixTiles(const formats::EncodedTable& matrices, int channels, MatrixShape shape)
      : table_bytes_(bytesOf(matrices)), cells_(shape.rows * shape.columns) {
    shape_ = shape;
    channels_ = channels;
    checkTable(matrices, matrices.rows, channels_ * cells_, "the table of matrices");
    tileInOrder(matrices.rows, kTilesPerRange);
    table_ = interleave(matrices, identity(matrices.columns));
  }

  LightTables prepare(std::span<const Float3> light) const override {
    LightTables tables;
    tables.light = copyLight(light);
    return tables;
  }

  std::size_t scratchSize() const override { return 0; }

  void transfer(std::size_t tile, const LightTables& light, float*, float* transferred) const override {
    forEachChannel(channels_, [&](int channel, int first_color, int last_color) {
      const std::size_t first = channel * cells_;
      const float* offset = table_.offset.data() == nullptr ? nullptr : table_.offset.data() + first;
      kernels().multiplyMatrices(table_.at(tile, first), offset, shape_, light.light.data(), first_color,
                                 last_color, transferred);
    });
  }

  std::size_t tableBytes() const override { return table_bytes_; }
  double multiplyAdds() const override {
    const std::size_t of_codes = table_.precision == Precision::kUint8 ? table_.entries : 0;
    return static_cast<double>(vertexCount() * (3 * cells_ + of_codes));
  }

 private:
  TileTable table_;
  std::size_t table_bytes_;
  std::size_t cells_;
};

// The product of visibility and y_j, made a matrix again for the 16 vertices of a tile: those matrices stay
// in the first-level cache. Γ_ijk is symmetric in i and j, so the cells i < j serve for j < i too.
class VisibilityTiles final : public GlossyTiles {
 public:
  VisibilityTiles(const formats::EncodedTable& visibility, const TripleProduct& product, MatrixShape shape)
      : table_bytes_(bytesOf(visibility)) {
    shape_ = shape;
    const std::size_t count = coefficientCount(product.visibilityOrder());
    checkTable(visibility, visibility.rows, count, "the table of visibility");
    tileInOrder(visibility.rows, kTilesPerRange);
    table_ = interleave(visibility, identity(count));
    planSums(product);
  }

  LightTables prepare(std::span<const Float3> light) const override {
    LightTables tables;
    tables.light = copyLight(light);
    return tables;
  }

  std::size_t scratchSize() const override { return (table_.entries + sum_count_) * kTile; }

  void transfer(std::size_t tile, const LightTables& light, float* scratch,
                float* transferred) const override {
    kernels().multiplySlots(expand(tile, scratch), slots_.data(), shape_, light.light.data(), transferred);
  }

  std::size_t tableBytes() const override { return table_bytes_; }
  double multiplyAdds() const override {
    return static_cast<double>(vertexCount() * (sum_terms_ + 3 * shape_.rows * shape_.columns));
  }

 private:
  // Cells of equal k, such as those of cos mφ · cos nφ and sin mφ · sin nφ, are summed up together.
  struct Batch {
    std::vector<std::uint16_t> sources;
    std::vector<std::uint32_t> cells;
  };

  void planSums(const TripleProduct& product) {
    const std::size_t square = std::min(shape_.rows, shape_.columns);
    std::map<std::uint32_t, std::vector<float>> factors_of_cell;
    std::map<std::vector<std::uint16_t>, std::vector<std::uint32_t>> cells_of_sources;
    const auto entries = product.entries();
    for (std::size_t first = 0, end = 0; first < entries.size(); first = end) {
      const auto& head = entries[first];
      const auto cell = static_cast<std::uint32_t>(head.i * shape_.columns + head.j);
      std::vector<std::uint16_t> sources;
      std::vector<float> factors;
      for (; end < entries.size() && entries[end].i == head.i && entries[end].j == head.j; ++end) {
        sources.push_back(static_cast<std::uint16_t>(entries[end].k * kTile));
        factors.push_back(entries[end].value);
      }
      if (head.j < head.i && head.i < square) continue;  // the mirrored cell serves
      sum_terms_ += factors.size();
      factors_of_cell[cell] = std::move(factors);
      cells_of_sources[std::move(sources)].push_back(cell);
    }

    std::vector<Batch> batches;
    for (const auto& [sources, cells] : cells_of_sources)
      for (std::size_t first = 0; first < cells.size(); first += kSumBatch)
        batches.push_back(
            {sources, {cells.begin() + first, cells.begin() + std::min(first + kSumBatch, cells.size())}});
    // Loops of equal length one after the other spare the processor wrong guesses of where they end.
    std::ranges::stable_sort(
        batches, {}, [](const Batch& batch) { return std::pair(batch.cells.size(), batch.sources.size()); });
    layOut(batches, factors_of_cell);
  }

  void layOut(const std::vector<Batch>& batches,
              const std::map<std::uint32_t, std::vector<float>>& factors_of_cell) {
    std::map<std::uint32_t, std::uint16_t> slot_of_cell;
    for (const auto& [sources, cells] : batches) {
      const SumGroup alike{0, static_cast<std::uint32_t>(cells.size()),
                           static_cast<std::uint32_t>(sources.size())};
      if (groups_.empty() || groups_.back().batch != alike.batch || groups_.back().length != alike.length)
        groups_.push_back(alike);
      ++groups_.back().batches;
      source_.insert(source_.end(), sources.begin(), sources.end());
      for (std::size_t e = 0; e < sources.size(); ++e)
        for (const std::uint32_t cell : cells) factor_.push_back(factors_of_cell.at(cell)[e]);
      for (const std::uint32_t cell : cells)
        slot_of_cell[cell] = static_cast<std::uint16_t>(slot_of_cell.size());
    }
    sum_count_ = slot_of_cell.size();
    const std::size_t square = std::min(shape_.rows, shape_.columns);
    for (std::uint32_t cell = 0; cell < shape_.rows * shape_.columns; ++cell) {
      const std::size_t i = cell / shape_.columns, j = cell % shape_.columns;
      const bool mirrored = j < i && i < square;
      slots_.push_back(slot_of_cell.at(mirrored ? static_cast<std::uint32_t>(j * shape_.columns + i) : cell));
    }
  }

  const float* expand(std::size_t tile, float* scratch) const {
    float* sums = scratch + table_.entries * kTile;
    const float* visibility = decoded(table_, tile, scratch);
    kernels().sparseSums(groups_.data(), groups_.size(), source_.data(), factor_.data(), visibility, sums);
    return sums;
  }

  TileTable table_;
  std::size_t table_bytes_;
  std::size_t sum_count_ = 0, sum_terms_ = 0;
  std::vector<SumGroup> groups_;
  std::vector<std::uint16_t> source_;  // positions of each batch, see SumGroup
  std::vector<float> factor_;          // Γ_ijk, see SumGroup
  std::vector<std::uint16_t> slots_;   // the sum of each cell
};

// The matrices of each cluster meet the light once, then every vertex combines the results.
class CpcaTiles final : public GlossyTiles {
 public:
  CpcaTiles(const formats::ClusteredOperator& clustered, int channels, MatrixShape shape)
      : scale_(clustered.basis.scale),
        offset_(clustered.basis.offset),
        components_(clustered.weights.columns),
        table_bytes_(bytesOf(clustered.weights) + bytesOf(clustered.basis) +
                     clustered.clusters.size() * sizeof(std::uint32_t)) {
    shape_ = shape;
    channels_ = channels;
    clusters_ = clustered.basis.rows / (1 + components_);
    checkTable(clustered.weights, clustered.clusters.size(), components_, "the table of weights");
    checkTable(clustered.basis, clusters_ * (1 + components_), channels_ * shape.rows * shape.columns,
               "the basis");
    tileByCluster(clustered.clusters, clusters_, kTilesPerClusterRange);
    weights_ = interleave(clustered.weights, identity(components_));
    interleaveBasis(clustered.basis);
  }

  LightTables prepare(std::span<const Float3> light) const override {
    LightTables tables;
    tables.light = copyLight(light);
    tables.offsets = transferOffsets(offset_, channels_, shape_, tables.light);
    const std::size_t lanes = rowLanes(shape_), cells = shape_.rows * shape_.columns;
    tables.lanes = AlignedFloats(shape_.columns * 3 * lanes);
    for (std::size_t j = 0; j < shape_.columns; ++j)
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < shape_.rows; ++i) {
          const std::size_t cell = (channels_ == 3 ? c : 0) * cells + i * shape_.columns + j;
          tables.lanes[(j * 3 + c) * lanes + i] =
              tables.light[j * 3 + c] * (scale_.empty() ? 1.0f : scale_[cell]);
        }
    return tables;
  }

  std::size_t scratchSize() const override { return productSize() + components_ * kTile; }

  void beginRange(const TileRange& range, const LightTables& light, float* scratch) const override {
    const std::size_t size = 3 * rowLanes(shape_);
    for (std::size_t member = 0; member <= components_; ++member) {
      if (offset_.empty())
        std::fill_n(scratch + member * size, size, 0.0f);
      else
        std::copy_n(light.offsets.data(), size, scratch + member * size);
    }
    forEachChannel(channels_, [&](int channel, int first_color, int last_color) {
      const std::size_t position = (range.cluster * channels_ + channel) * clusterEntries();
      const TileValues values{basis_precision_,
                              basis_.data() + position * formats::bytesPerValue(basis_precision_), nullptr};
      kernels().multiplyBasis(values, 1 + components_, shape_, light.lanes.data(), first_color, last_color,
                              scratch);
    });
  }

  void transfer(std::size_t tile, const LightTables&, float* scratch, float* transferred) const override {
    kernels().transferCluster(scratch, components_, decodedWeights(tile, scratch), shape_.rows, transferred);
  }

  std::size_t tableBytes() const override { return table_bytes_; }
  double multiplyAdds() const override {
    const std::size_t products = clusters_ * (1 + components_) * shape_.rows * shape_.columns * 3;
    return static_cast<double>(products + vertexCount() * 3 * shape_.rows * (components_ + 1));
  }

 private:
  std::size_t productSize() const { return (1 + components_) * 3 * rowLanes(shape_); }
  // Values of one cluster and channel.
  std::size_t clusterEntries() const { return (1 + components_) * shape_.columns * rowLanes(shape_); }

  // To the order of Kernels::multiplyBasis.
  void interleaveBasis(const EncodedTable& table) {
    basis_precision_ = table.precision;
    const std::size_t size = formats::bytesPerValue(table.precision), cells = shape_.rows * shape_.columns;
    basis_ = Aligned<std::byte>(clusters_ * channels_ * clusterEntries() * size);
    const Blocks blocks{1 + components_, kRowBlock};
    std::byte* target = basis_.data();
    for (std::size_t cluster = 0; cluster < clusters_; ++cluster)
      for (int channel = 0; channel < channels_; ++channel)
        for (std::size_t block = 0; block < blocks.blocks(); ++block)
          for (std::size_t first_row = 0; first_row < shape_.rows; first_row += kTile)
            for (std::size_t j = 0; j < shape_.columns; ++j)
              for (std::size_t member = blocks.begin(block); member < blocks.begin(block + 1); ++member) {
                const std::size_t row = cluster * (1 + components_) + member;
                for (std::size_t i = first_row; i < std::min(first_row + kTile, shape_.rows); ++i)
                  std::copy_n(
                      &table.data[row * table.rowBytes() + (channel * cells + i * shape_.columns + j) * size],
                      size, target + (i - first_row) * size);
                target += kTile * size;
              }
  }

  const float* decodedWeights(std::size_t tile, float* scratch) const {
    return decoded(weights_, tile, scratch + productSize());
  }

  TileTable weights_;
  Precision basis_precision_ = Precision::kFloat32;
  Aligned<std::byte> basis_;
  std::vector<float> scale_, offset_;  // of the basis, a cell
  std::size_t components_, clusters_ = 0;
  std::size_t table_bytes_;
};

}  // namespace

std::unique_ptr<const GlossyTiles> makeGlossyTiles(const formats::ShTransfer& transfer) {
  require(transfer.glossy.has_value(), "the transfer has no matrices");
  const formats::GlossyTransfer& glossy = *transfer.glossy;
  require(transfer.order >= 1 && transfer.order <= kMaxOrder && glossy.output_order >= 1 &&
              glossy.output_order <= kMaxOrder && (transfer.channels == 1 || transfer.channels == 3),
          "orders or channels are out of range");
  const MatrixShape shape{static_cast<std::size_t>(coefficientCount(glossy.output_order)),
                          static_cast<std::size_t>(coefficientCount(transfer.order))};
  if (const auto* visibility = std::get_if<formats::VisibilityOperator>(&glossy.transfer)) {
    require(transfer.channels == 1, "visibility has one channel");
    return std::make_unique<VisibilityTiles>(visibility->visibility,
                                             TripleProduct(glossy.output_order, transfer.order), shape);
  }
  if (const auto* clustered = std::get_if<formats::ClusteredOperator>(&glossy.transfer))
    return std::make_unique<CpcaTiles>(*clustered, transfer.channels, shape);
  return std::make_unique<MatrixTiles>(std::get<formats::MatrixOperator>(glossy.transfer).matrices,
                                       transfer.channels, shape);
}

}  // namespace bakelight::transport
