// Sloan, Hall, Hart & Snyder, "Clustered Principal Components for Precomputed Radiance Transfer", 2003,
// sections 4.1–4.3: vector quantisation that turns into CPCA by letting the number of components grow with
// the rounds ("adaptive PCA"), which falls into fewer bad local minima than full components from the start.
#include "tools/transfer/cpca.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>
#include <limits>
#include <mutex>
#include <stdexcept>

namespace bakelight::transfer {
namespace {

using Eigen::Index;
using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using RowsView = Eigen::Map<const Rows>;

constexpr Index kChunk = 128;        // vectors that are worked on together: sums do not depend on the threads
constexpr int kOversampling = 8;     // extra directions of the subspace iteration, which speed it up
constexpr int kRoundPowers = 2;      // its steps within a round, from the last round's components
constexpr int kFinalPowers = 12;     // and at the end
constexpr double kRounding = 1e-13;  // share of the energy that counts as rounding of single precision

struct Cluster {
  std::vector<Index> members;
  Eigen::VectorXf mean;
  Eigen::MatrixXf components;  // dimension × components, orthonormal or zero columns
};

// Eigen splits the sums of a matrix product by the sizes of the caches; the same splits everywhere give the
// same bytes everywhere.
void fixSplitsOfProducts() {
  static std::once_flag once;
  std::call_once(once, [] { Eigen::setCpuCacheSizes(32 << 10, 512 << 10, 4 << 20); });
}

// A fixed value in [−1, 1) for each row and column (the finaliser of SplitMix64).
double hashed(std::uint64_t row, std::uint64_t column) {
  std::uint64_t x = (row << 20 ^ column) + 0x9E3779B97F4A7C15u;
  x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9u;
  x = (x ^ x >> 27) * 0x94D049BB133111EBu;
  return static_cast<double>((x ^ x >> 31) >> 11) / static_cast<double>(std::uint64_t{1} << 52) - 1;
}

Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& columns) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(columns);
  return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), columns.cols());
}

Eigen::VectorXf meanOf(const RowsView& vectors, const std::vector<Index>& members) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(vectors.cols());
  for (const Index member : members) sum += vectors.row(member).cast<double>();
  return (sum / static_cast<double>(members.size())).cast<float>();
}

Rows centered(const RowsView& vectors, const Cluster& cluster) {
  Rows result(static_cast<Index>(cluster.members.size()), vectors.cols());
  for (Index row = 0; row < result.rows(); ++row)
    result.row(row) = vectors.row(cluster.members[row]) - cluster.mean.transpose();
  return result;
}

// The leading right singular vectors of `rows` by subspace iteration (Halko, Martinsson & Tropp 2011),
// started from `start`; columns whose singular value is rounding (energy ≤ `floor`) are zero.
Eigen::MatrixXf principalComponents(const Rows& rows, const Eigen::MatrixXf& start, int components,
                                    int powers, double floor) {
  const Index dimension = rows.cols(), block = std::min<Index>(components + kOversampling, dimension);
  Eigen::MatrixXd basis(dimension, block);
  for (Index j = 0; j < block; ++j)
    for (Index i = 0; i < dimension; ++i) basis(i, j) = hashed(i, j);
  if (start.size() > 0) basis.leftCols(start.cols()) += 1e3 * start.cast<double>();
  basis = orthonormal(basis);

  Rows image = rows * basis.cast<float>();
  for (int power = 0; power < powers; ++power) {
    basis = orthonormal(Eigen::MatrixXf(rows.transpose() * image).cast<double>());
    image = rows * basis.cast<float>();
  }
  const Eigen::MatrixXd image_double = image.cast<double>();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz(image_double.transpose() * image_double);

  Eigen::MatrixXf result = Eigen::MatrixXf::Zero(dimension, components);
  for (Index k = 0; k < std::min<Index>(components, block); ++k) {
    const Index from = block - 1 - k;  // eigenvalues come in ascending order
    if (ritz.eigenvalues()(from) > floor)
      result.col(k) = (basis * ritz.eigenvectors().col(from)).cast<float>();
  }
  return result;
}

// Farthest-point seeds: each is the vector farthest from all before, the first the one farthest from the
// origin.
std::vector<Cluster> seedClusters(const RowsView& vectors, int count) {
  std::vector<Cluster> clusters;
  Eigen::VectorXf distance = vectors.rowwise().squaredNorm();
  Index farthest = 0;
  distance.maxCoeff(&farthest);
  const float floor = static_cast<float>(kRounding) * distance(farthest);
  distance.setConstant(std::numeric_limits<float>::infinity());
  while (static_cast<int>(clusters.size()) < count && distance(farthest) > floor) {
    clusters.push_back({{}, vectors.row(farthest), Eigen::MatrixXf(vectors.cols(), 0)});
    const Eigen::VectorXf& seed = clusters.back().mean;
    tbb::parallel_for(Index{0}, (vectors.rows() + kChunk - 1) / kChunk, [&](Index chunk) {
      for (Index row = chunk * kChunk; row < std::min(vectors.rows(), (chunk + 1) * kChunk); ++row)
        distance(row) = std::min(distance(row), (vectors.row(row) - seed.transpose()).squaredNorm());
    });
    distance.maxCoeff(&farthest);
  }
  return clusters;
}

// To the cluster whose mean and components leave the least error; the first of equals.
void assign(const RowsView& vectors, std::vector<Cluster>& clusters) {
  const Index count = static_cast<Index>(clusters.size()), dimension = vectors.cols();
  const Index components = clusters.front().components.cols();
  // One product gives all x·μ and x·b. |x − μ|² − |bᵀ(x − μ)|² then needs no other pass over the vectors; x
  // is taken relative to the mean of means, as differences of large numbers lose digits.
  Eigen::VectorXf origin = Eigen::VectorXf::Zero(dimension);
  for (const Cluster& cluster : clusters) origin += cluster.mean / static_cast<float>(count);
  Eigen::MatrixXf means(dimension, count), bases(dimension, count * components);
  Eigen::VectorXf mean_norms(count);
  Eigen::RowVectorXf offsets(count * components);
  for (Index c = 0; c < count; ++c) {
    means.col(c) = clusters[c].mean - origin;
    mean_norms(c) = means.col(c).squaredNorm();
    bases.middleCols(c * components, components) = clusters[c].components;
    offsets.segment(c * components, components) = means.col(c).transpose() * clusters[c].components;
  }

  std::vector<Index> nearest(vectors.rows());
  tbb::parallel_for(Index{0}, (vectors.rows() + kChunk - 1) / kChunk, [&](Index chunk) {
    const Index begin = chunk * kChunk, rows = std::min(kChunk, vectors.rows() - begin);
    const Rows shifted = vectors.middleRows(begin, rows).rowwise() - origin.transpose();
    const Rows along_means = shifted * means;
    const Rows projected = (shifted * bases).rowwise() - offsets;
    for (Index row = 0; row < rows; ++row) {
      float least = std::numeric_limits<float>::infinity();
      for (Index c = 0; c < count; ++c) {
        const float error = mean_norms(c) - 2 * along_means(row, c) -
                            projected.row(row).segment(c * components, components).squaredNorm();
        if (error < least) least = error, nearest[begin + row] = c;
      }
    }
  });
  for (Cluster& cluster : clusters) cluster.members.clear();
  for (Index row = 0; row < vectors.rows(); ++row) clusters[nearest[row]].members.push_back(row);
  std::erase_if(clusters, [](const Cluster& cluster) { return cluster.members.empty(); });
}

void refit(const RowsView& vectors, std::vector<Cluster>& clusters, int components, int powers) {
  tbb::parallel_for(std::size_t{0}, clusters.size(), [&](std::size_t c) {
    Cluster& cluster = clusters[c];
    cluster.mean = meanOf(vectors, cluster.members);
    const Rows rows = centered(vectors, cluster);
    const double energy = rows.squaredNorm() + static_cast<double>(rows.rows()) * cluster.mean.squaredNorm();
    cluster.components =
        principalComponents(rows, cluster.components, components, powers, kRounding * energy);
  });
}

// One more every few rounds; all of them for the last third.
int componentsIn(int round, const CpcaOptions& options) {
  const int growing = 1 + 3 * round * options.components / (2 * options.iterations);
  return std::min(options.components, growing);
}

Cpca describe(const RowsView& vectors, const std::vector<Cluster>& clusters, int components) {
  const Index dimension = vectors.cols();
  Cpca result;
  result.cluster_count = static_cast<std::uint32_t>(clusters.size());
  result.components = components;
  result.clusters.resize(vectors.rows());
  result.weights.resize(vectors.rows() * components);
  result.basis.resize(clusters.size() * (1 + components) * dimension);
  std::vector<double> squared_errors(clusters.size());
  tbb::parallel_for(std::size_t{0}, clusters.size(), [&](std::size_t c) {
    const Cluster& cluster = clusters[c];
    Eigen::Map<Eigen::MatrixXf> basis(&result.basis[c * (1 + components) * dimension], dimension,
                                      1 + components);
    basis << cluster.mean, cluster.components;
    const Rows rows = centered(vectors, cluster);
    const Rows weights = rows * cluster.components;
    squared_errors[c] = (rows - weights * cluster.components.transpose()).cast<double>().squaredNorm();
    for (Index row = 0; row < rows.rows(); ++row) {
      const Index member = cluster.members[row];
      result.clusters[member] = static_cast<std::uint32_t>(c);
      std::copy_n(weights.row(row).data(), components, result.weights.begin() + member * components);
    }
  });
  double error = 0, norm = 0;
  for (const double squared : squared_errors) error += squared;
  for (Index row = 0; row < vectors.rows(); ++row) norm += vectors.row(row).cast<double>().squaredNorm();
  result.relative_error = norm > 0 ? std::sqrt(error / norm) : 0;
  return result;
}

}  // namespace

Cpca clusteredPca(std::span<const float> vectors, std::size_t dimension, const CpcaOptions& options,
                  const std::function<void()>& round_done) {
  if (dimension == 0 || vectors.empty() || vectors.size() % dimension != 0)
    throw std::invalid_argument("clusteredPca: the vectors do not fit their dimension");
  if (options.clusters < 1 || options.components < 1 || options.iterations < 1)
    throw std::invalid_argument("clusteredPca: options below 1");
  fixSplitsOfProducts();
  const RowsView view(vectors.data(), static_cast<Index>(vectors.size() / dimension),
                      static_cast<Index>(dimension));

  std::vector<Cluster> clusters = seedClusters(view, options.clusters);
  for (int round = 0; round < options.iterations; ++round) {
    assign(view, clusters);
    const int components = componentsIn(round, options);
    const bool last = round + 1 == options.iterations;
    refit(view, clusters, last ? options.components : components, last ? kFinalPowers : kRoundPowers);
    if (round_done) round_done();
  }
  return describe(view, clusters, options.components);
}

}  // namespace bakelight::transfer
