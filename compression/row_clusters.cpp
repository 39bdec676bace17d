#include "compression/row_clusters.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <Eigen/Dense>
#include <limits>
#include <mutex>
#include <stdexcept>

#include "transport/random.h"

namespace bakelight::compression {
namespace {

using Eigen::Index;
using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr std::size_t kRowsAtOnce = 2048;  // sums do not depend on the threads
constexpr Index kOversampling = 6;         // extra directions of the subspace iteration, which speed it up
constexpr int kRoundPowers = 2, kLastPowers = 6;  // its steps within a round and at the end
constexpr float kRounding = 1e-9F;  // share of the energy that counts as rounding of single precision

// Eigen splits the sums of a matrix product by the sizes of the caches; the same splits everywhere give the
// same bytes everywhere.
void fixSplitsOfProducts() {
  static std::once_flag once;
  std::call_once(once, [] { Eigen::setCpuCacheSizes(32 << 10, 512 << 10, 4 << 20); });
}

// In [0, 1).
double fixedNumber(std::uint64_t place) {
  return static_cast<double>(transport::scrambled(place) >> 11) * 0x1p-53;
}

struct Cluster {
  std::vector<std::uint32_t> members;
  Eigen::VectorXf mean;
  Eigen::MatrixXf components;  // columns × components, orthonormal or zero columns
};

class Clustering {
 public:
  Clustering(const formats::PixelCodes& codes, const ClusterOptions& options)
      : codes_(codes),
        options_(options),
        scale_(1.0F / static_cast<float>(codes.subsamples * codes.subsamples)) {
    for (std::size_t row = 0; row < codes.rowCount(); ++row)
      if (codes.row_offsets[row] < codes.row_offsets[row + 1])
        rows_.push_back(static_cast<std::uint32_t>(row));
    norms_.resize(rows_.size());
    for (std::size_t i = 0; i < rows_.size(); ++i)
      forEntries(rows_[i], [&](std::size_t, float value) { norms_[i] += value * value; });
  }

  RowClusters run() {
    seed();
    for (int round = 0; round < options_.rounds && !rows_.empty(); ++round) {
      assign();
      const bool last = round + 1 == options_.rounds;
      const int growing =
          std::min(options_.components, 1 + 3 * round * options_.components / (2 * options_.rounds));
      refit(last ? options_.components : growing, last ? kLastPowers : kRoundPowers);
    }
    return describe();
  }

 private:
  template <class Visit>
  void forEntries(std::uint32_t row, Visit visit) const {
    for (std::uint64_t i = codes_.row_offsets[row]; i < codes_.row_offsets[row + 1]; ++i)
      visit(codes_.columns[i], static_cast<float>(codes_.codes[i]) * scale_);
  }

  Eigen::VectorXf dense(std::uint32_t row) const {
    Eigen::VectorXf result = Eigen::VectorXf::Zero(static_cast<Index>(codes_.columnCount()));
    forEntries(row, [&](std::size_t column, float value) { result(static_cast<Index>(column)) = value; });
    return result;
  }

  // Each with a probability in proportion to its squared distance from the nearest before.
  void seed() {
    if (rows_.empty()) return;
    std::vector<float> distances = norms_;
    for (int c = 0; c < options_.clusters; ++c) {
      double sum = 0;
      for (const float distance : distances) sum += distance;
      if (!(sum > 0)) break;
      double left = fixedNumber(static_cast<std::uint64_t>(c)) * sum;
      std::size_t chosen = 0;
      while (chosen + 1 < distances.size() && left >= distances[chosen]) left -= distances[chosen++];
      while (distances[chosen] <= 0) chosen = chosen == 0 ? distances.size() - 1 : chosen - 1;
      clusters_.push_back({{}, dense(rows_[chosen]), Eigen::MatrixXf(codes_.columnCount(), 0)});
      const Eigen::VectorXf& mean = clusters_.back().mean;
      const float norm = mean.squaredNorm();
      tbb::parallel_for(
          tbb::blocked_range<std::size_t>(0, rows_.size(), kRowsAtOnce), [&](const auto& range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
              float product = 0;
              forEntries(rows_[i], [&](std::size_t column, float value) {
                product += value * mean(static_cast<Index>(column));
              });
              distances[i] = std::min(distances[i], std::max(0.0F, norms_[i] - 2 * product + norm));
            }
          });
      distances[chosen] = 0;
    }
  }

  // To the cluster whose mean and components leave the least error: |x − m|² − |Bᵀ(x − m)|², less |x|²; the first of equals.
  void assign() {
    const Index count = static_cast<Index>(clusters_.size()),
                components = clusters_.front().components.cols(), width = 1 + components,
                columns = static_cast<Index>(codes_.columnCount());
    Rows table(columns, count * width);
    Eigen::VectorXf mean_norms(count);
    Eigen::RowVectorXf offsets = Eigen::RowVectorXf::Zero(count * width);
    for (Index c = 0; c < count; ++c) {
      const Cluster& cluster = clusters_[c];
      table.col(c * width) = cluster.mean;
      table.middleCols(c * width + 1, components) = cluster.components;
      mean_norms(c) = cluster.mean.squaredNorm();
      offsets.segment(c * width + 1, components) = cluster.mean.transpose() * cluster.components;
    }
    std::vector<std::uint32_t> nearest(rows_.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rows_.size(), kRowsAtOnce), [&](const auto& range) {
      Eigen::RowVectorXf along(count * width);
      for (std::size_t i = range.begin(); i < range.end(); ++i) {
        along = -offsets;
        forEntries(rows_[i], [&](std::size_t column, float value) {
          along += value * table.row(static_cast<Index>(column));
        });
        float least = std::numeric_limits<float>::infinity();
        for (Index c = 0; c < count; ++c) {
          const float error =
              mean_norms(c) - 2 * along(c * width) - along.segment(c * width + 1, components).squaredNorm();
          if (error < least) least = error, nearest[i] = static_cast<std::uint32_t>(c);
        }
      }
    });
    for (Cluster& cluster : clusters_) cluster.members.clear();
    for (std::size_t i = 0; i < rows_.size(); ++i) clusters_[nearest[i]].members.push_back(rows_[i]);
    std::erase_if(clusters_, [](const Cluster& cluster) { return cluster.members.empty(); });
  }

  // (members − mean) · basis.
  Rows project(const Cluster& cluster, const Rows& basis) const {
    Rows result(static_cast<Index>(cluster.members.size()), basis.cols());
    const Eigen::RowVectorXf offset = cluster.mean.transpose() * basis;
    for (Index i = 0; i < result.rows(); ++i) {
      result.row(i) = -offset;
      forEntries(cluster.members[i], [&](std::size_t column, float value) {
        result.row(i) += value * basis.row(static_cast<Index>(column));
      });
    }
    return result;
  }

  // (members − mean)ᵀ · image. Columns of `image` sum up to what rounding left.
  Rows projectBack(const Cluster& cluster, const Rows& image) const {
    Rows result = -cluster.mean * image.colwise().sum();
    for (Index i = 0; i < image.rows(); ++i)
      forEntries(cluster.members[i], [&](std::size_t column, float value) {
        result.row(static_cast<Index>(column)) += value * image.row(i);
      });
    return result;
  }

  static Rows orthonormal(const Rows& columns) {
    const Eigen::HouseholderQR<Eigen::MatrixXf> qr(columns);
    return qr.householderQ() * Eigen::MatrixXf::Identity(columns.rows(), columns.cols());
  }

  void refit(int components, int powers) {
    tbb::parallel_for(std::size_t{0}, clusters_.size(), [&](std::size_t c) {
      Cluster& cluster = clusters_[c];
      Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Index>(codes_.columnCount()));
      double energy = 0;
      for (const std::uint32_t member : cluster.members)
        forEntries(member, [&](std::size_t column, float value) {
          sum(static_cast<Index>(column)) += value;
          energy += value * value;
        });
      cluster.mean = (sum / static_cast<double>(cluster.members.size())).cast<float>();
      if (components > 0)
        cluster.components =
            principalComponents(cluster, components, powers, kRounding * static_cast<float>(energy));
    });
  }

  // The leading right singular vectors by subspace iteration (Halko, Martinsson & Tropp 2011), from those that there are.
  Eigen::MatrixXf principalComponents(const Cluster& cluster, int components, int powers, float floor) const {
    const Index columns = cluster.mean.size(), block = std::min({components + kOversampling, columns,
                                                                 static_cast<Index>(cluster.members.size())});
    Eigen::MatrixXf result = Eigen::MatrixXf::Zero(columns, components);
    // What rows of the cluster there are spans all that is looked for.
    Rows image(static_cast<Index>(cluster.members.size()), block);
    for (Index i = 0; i < image.rows(); ++i)
      for (Index j = 0; j < block; ++j)
        image(i, j) = static_cast<float>(fixedNumber(static_cast<std::uint64_t>(i * block + j)) - 0.5);
    if (cluster.components.cols() > 0) {
      const Index known = std::min(block, cluster.components.cols());
      image.leftCols(known) += 1e3F * project(cluster, cluster.components.leftCols(known));
    }
    Rows basis;
    for (int power = 0; power < powers; ++power) {
      basis = orthonormal(projectBack(cluster, image));
      image = project(cluster, basis);
    }
    const Eigen::MatrixXd exact = image.cast<double>();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz(exact.transpose() * exact);
    for (Index k = 0; k < std::min<Index>(components, block); ++k) {
      const Index from = block - 1 - k;  // eigenvalues come in ascending order
      if (ritz.eigenvalues()(from) > floor)
        result.col(k) = basis * ritz.eigenvectors().col(from).cast<float>();
    }
    return result;
  }

  RowClusters describe() const {
    RowClusters result;
    result.cube_side = codes_.cube_side;
    result.components = options_.components;
    result.clusters.assign(codes_.rowCount(), RowClusters::kNone);
    result.weights.assign(codes_.rowCount() * options_.components, 0);
    result.bases.resize(clusters_.size());
    tbb::parallel_for(std::size_t{0}, clusters_.size(), [&](std::size_t c) {
      const Cluster& cluster = clusters_[c];
      result.bases[c].resize(cluster.mean.size(), 1 + options_.components);
      result.bases[c] << cluster.mean, cluster.components;
      const Rows weights = project(cluster, cluster.components);
      for (Index i = 0; i < weights.rows(); ++i) {
        const std::size_t member = cluster.members[i];
        result.clusters[member] = static_cast<std::int32_t>(c);
        std::copy_n(weights.row(i).data(), options_.components,
                    result.weights.begin() + static_cast<std::ptrdiff_t>(member * options_.components));
      }
    });
    return result;
  }

  const formats::PixelCodes codes_;
  const ClusterOptions options_;
  const float scale_;
  std::vector<std::uint32_t> rows_;  // that have entries
  std::vector<float> norms_;
  std::vector<Cluster> clusters_;
};

}  // namespace

RowClusters clusterRows(const formats::PixelCodes& codes, const ClusterOptions& options) {
  if (options.clusters < 1 || options.components < 0 || options.rounds < 1)
    throw std::invalid_argument("clusterRows: options below 1");
  fixSplitsOfProducts();
  return Clustering(codes, options).run();
}

}  // namespace bakelight::compression
