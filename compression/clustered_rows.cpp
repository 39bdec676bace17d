#include "compression/clustered_rows.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "formats/symbol_code.h"

namespace bakelight::compression {
namespace {

using Eigen::Index;

constexpr std::size_t kRowsAtOnce = 4096;

// Σ over a cluster's rows of the squares of what a column of its basis is multiplied by.
std::vector<Eigen::VectorXf> energiesOf(const RowClusters& rows) {
  std::vector<Eigen::VectorXd> sums(rows.bases.size(), Eigen::VectorXd::Zero(1 + rows.components));
  for (std::size_t row = 0; row < rows.clusters.size(); ++row) {
    if (rows.clusters[row] == RowClusters::kNone) continue;
    Eigen::VectorXd& sum = sums[rows.clusters[row]];
    sum(0) += 1;
    for (int k = 0; k < rows.components; ++k) {
      const double weight = rows.weights[row * rows.components + k];
      sum(1 + k) += weight * weight;
    }
  }
  std::vector<Eigen::VectorXf> result;
  for (const Eigen::VectorXd& sum : sums) result.push_back(sum.cast<float>());
  return result;
}

struct Quantized {
  float step = 1;
  std::vector<std::int32_t> weights;             // rows × components
  std::vector<std::vector<std::int32_t>> bases;  // columns of each basis behind each other, times their sizes
};

Quantized quantized(const RowClusters& rows, std::span<const Eigen::VectorXf> energies, float step) {
  Quantized result;
  result.step = step;
  result.weights.resize(rows.weights.size());
  for (std::size_t i = 0; i < rows.weights.size(); ++i)
    result.weights[i] = static_cast<std::int32_t>(std::lround(rows.weights[i] / step));
  result.bases.resize(rows.bases.size());
  tbb::parallel_for(std::size_t{0}, rows.bases.size(), [&](std::size_t c) {
    const Eigen::MatrixXf& basis = rows.bases[c];
    for (Index k = 0; k < basis.cols(); ++k) {
      const float factor = std::sqrt(energies[c](k)) / step;
      for (Index i = 0; i < basis.rows(); ++i)
        result.bases[c].push_back(static_cast<std::int32_t>(std::lround(basis(i, k) * factor)));
    }
  });
  return result;
}

std::uint64_t bytesOf(const RowClusters& rows, const Quantized& table) {
  std::vector<std::vector<std::uint32_t>> streams(2 + rows.components);
  for (std::size_t row = 0; row < rows.clusters.size(); ++row) {
    streams[0].push_back(static_cast<std::uint32_t>(rows.clusters[row] + 1));
    if (rows.clusters[row] == RowClusters::kNone) continue;
    for (int k = 0; k < rows.components; ++k)
      streams[2 + k].push_back(formats::symbolOf(table.weights[row * rows.components + k]));
  }
  for (const auto& basis : table.bases)
    for (const std::int32_t value : basis) streams[1].push_back(formats::symbolOf(value));
  // A size a column of each basis, as a float.
  std::uint64_t sum = sizeof(float) * rows.bases.size() * (1 + rows.components);
  for (const auto& stream : streams) sum += formats::encodeSymbols(stream).size();
  return sum;
}

// What is multiplied with light: numbers as they come out of the table.
RowClusters dequantized(const RowClusters& rows, std::span<const Eigen::VectorXf> energies,
                        const Quantized& table) {
  RowClusters result = rows;
  for (std::size_t i = 0; i < result.weights.size(); ++i)
    result.weights[i] = static_cast<float>(table.weights[i]) * table.step;
  for (std::size_t c = 0; c < result.bases.size(); ++c) {
    Eigen::MatrixXf& basis = result.bases[c];
    std::size_t next = 0;
    for (Index k = 0; k < basis.cols(); ++k) {
      const float size = std::sqrt(energies[c](k));
      for (Index i = 0; i < basis.rows(); ++i, ++next)
        basis(i, k) = size > 0 ? static_cast<float>(table.bases[c][next]) * table.step / size : 0;
    }
  }
  return result;
}

void multiply(const RowClusters& rows, std::span<const Radiance4> light, std::span<Radiance4> values) {
  const Index width = 1 + rows.components;
  const Eigen::Map<const Eigen::Matrix<float, 4, Eigen::Dynamic>> colors(light.front().data(), 4,
                                                                         static_cast<Index>(light.size()));
  std::vector<Radiance4> products(rows.bases.size() * width);
  tbb::parallel_for(std::size_t{0}, rows.bases.size(), [&](std::size_t c) {
    const Eigen::Matrix<float, 4, Eigen::Dynamic> product = colors.lazyProduct(rows.bases[c]);
    for (Index k = 0; k < width; ++k) products[c * width + k] = product.col(k);
  });
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rows.clusters.size(), kRowsAtOnce),
                    [&](const auto& range) {
                      for (std::size_t row = range.begin(); row < range.end(); ++row) {
                        if (rows.clusters[row] == RowClusters::kNone) {
                          values[row] = Radiance4::Zero();
                          continue;
                        }
                        const Radiance4* product = &products[rows.clusters[row] * width];
                        Radiance4 sum = product[0];
                        for (int k = 0; k < rows.components; ++k)
                          sum += product[1 + k] * rows.weights[row * rows.components + k];
                        values[row] = sum;
                      }
                    });
}

// Σ over rows of |row of the matrix − what stands for it|².
double squaredError(const formats::PixelCodes& codes, const RowClusters& rows) {
  std::vector<Eigen::MatrixXf> grams;
  for (const Eigen::MatrixXf& basis : rows.bases) grams.emplace_back(basis.transpose() * basis);
  const float scale = 1.0F / static_cast<float>(codes.subsamples * codes.subsamples);
  std::vector<double> parts((codes.rowCount() + kRowsAtOnce - 1) / kRowsAtOnce);
  std::vector<Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> bases(rows.bases.begin(),
                                                                                           rows.bases.end());
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t part) {
    Eigen::VectorXf weights(1 + rows.components), along(1 + rows.components);
    for (std::size_t row = part * kRowsAtOnce; row < std::min(codes.rowCount(), (part + 1) * kRowsAtOnce);
         ++row) {
      if (rows.clusters[row] == RowClusters::kNone) continue;
      const std::int32_t cluster = rows.clusters[row];
      weights(0) = 1;
      for (int k = 0; k < rows.components; ++k) weights(1 + k) = rows.weights[row * rows.components + k];
      along.setZero();
      float norm = 0;
      for (std::uint64_t i = codes.row_offsets[row]; i < codes.row_offsets[row + 1]; ++i) {
        const float value = static_cast<float>(codes.codes[i]) * scale;
        norm += value * value;
        along += value * bases[cluster].row(codes.columns[i]).transpose();
      }
      parts[part] += norm - 2 * along.dot(weights) + weights.dot(grams[cluster] * weights);
    }
  });
  double sum = 0;
  for (const double part : parts) sum += part;
  return sum;
}

struct Within {
  RowClusters rows;
  std::uint64_t bytes = 0;
};

Within within(std::uint64_t budget, const RowClusters& rows) {
  const std::vector<Eigen::VectorXf> energies = energiesOf(rows);
  const auto stepAt = [](double position) {
    constexpr double kOctaves = 18;
    return static_cast<float>(64 * std::exp2(kOctaves * (position - 1)));
  };
  const Solved solved = solveForBytes(
      [&](double position) { return bytesOf(rows, quantized(rows, energies, stepAt(position))); }, budget);
  return {dequantized(rows, energies, quantized(rows, energies, stepAt(solved.at))), solved.bytes};
}

CompressedTransfer transferOf(Within found) {
  const auto result = std::make_shared<const RowClusters>(std::move(found.rows));
  CompressedTransfer transfer;
  transfer.name = "cpca";
  transfer.parameters = std::to_string(result->bases.size()) + " clusters of " +
                        std::to_string(result->components) + " components";
  transfer.bytes = found.bytes;
  std::uint64_t entries = 0;
  for (const Eigen::MatrixXf& basis : result->bases)
    entries += static_cast<std::uint64_t>((basis.array() != 0).count());
  const auto full =
      static_cast<std::uint64_t>(std::count_if(result->clusters.begin(), result->clusters.end(),
                                               [](std::int32_t c) { return c != RowClusters::kNone; }));
  transfer.operations = 2 * entries + 2 * full * static_cast<std::uint64_t>(result->components);
  transfer.value_count = result->clusters.size();
  transfer.multiply = [result](std::span<const Radiance4> light, std::span<Radiance4> values) {
    multiply(*result, light, values);
  };
  return transfer;
}

}  // namespace

CompressedTransfer clusteredWithin(std::uint64_t budget, const RowClusters& rows) {
  return transferOf(within(budget, rows));
}

CompressedTransfer clusteredWithin(std::uint64_t budget, const formats::PixelCodes& codes,
                                   std::span<const int> components_tried, int rounds) {
  // Of a weight and of an entry of a basis, most of which are 0, after coding, as found with bunnies.
  constexpr double kBytesOfWeight = 0.5, kBytesOfEntry = 0.12, kBytesOfCluster = 0.5;
  const double rows = static_cast<double>(codes.rowCount()),
               columns = static_cast<double>(codes.columnCount());
  std::optional<Within> best;
  double least = std::numeric_limits<double>::infinity();
  for (const int components : components_tried) {
    const double for_bases =
        static_cast<double>(budget) - rows * (kBytesOfCluster + kBytesOfWeight * components);
    const int clusters =
        static_cast<int>(std::clamp(for_bases / (kBytesOfEntry * columns * (1 + components)), 1.0, 256.0));
    Within found = within(
        budget, clusterRows(codes, {.clusters = clusters, .components = components, .rounds = rounds}));
    if (const double error = squaredError(codes, found.rows); error < least) {
      least = error;
      best = std::move(found);
    }
  }
  if (!best) throw std::invalid_argument("clusteredWithin: no number of components to try");
  return transferOf(std::move(*best));
}

}  // namespace bakelight::compression
