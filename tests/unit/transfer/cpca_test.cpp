#include "tools/transfer/cpca.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <stdexcept>

namespace bakelight::transfer {
namespace {

constexpr std::size_t kDimension = 30;

// Vectors from `families` well separated affine spaces of dimension `rank` each, all numbers from a fixed
// seed.
std::vector<float> affineFamilies(std::size_t count, int families, int rank, unsigned seed = 1) {
  const auto next = [&seed] {
    seed = seed * 1664525u + 1013904223u;
    return static_cast<double>(seed >> 8) / (1 << 23) - 1;
  };
  std::vector<std::vector<double>> spans(families);
  for (auto& span : spans)
    for (std::size_t i = 0; i < (1 + rank) * kDimension; ++i)
      span.push_back(next() * (i < kDimension ? 20 : 1));
  std::vector<float> vectors;
  for (std::size_t v = 0; v < count; ++v) {
    const std::vector<double>& span = spans[v % families];
    std::vector<double> vector(span.begin(), span.begin() + kDimension);
    for (int r = 1; r <= rank; ++r) {
      const double weight = next();
      for (std::size_t i = 0; i < kDimension; ++i) vector[i] += weight * span[r * kDimension + i];
    }
    for (const double value : vector) vectors.push_back(static_cast<float>(value));
  }
  return vectors;
}

// √(Σ|x − x'|² / Σ|x|²) from what is stored.
double reconstructionError(std::span<const float> vectors, const Cpca& cpca,
                           std::size_t dimension = kDimension) {
  double error = 0, norm = 0;
  for (std::size_t v = 0; v < vectors.size() / dimension; ++v) {
    const float* basis = &cpca.basis[cpca.clusters[v] * (1 + cpca.components) * dimension];
    for (std::size_t i = 0; i < dimension; ++i) {
      double value = basis[i];
      for (int k = 0; k < cpca.components; ++k)
        value += double{cpca.weights[v * cpca.components + k]} * basis[(1 + k) * dimension + i];
      error += std::pow(value - vectors[v * dimension + i], 2);
      norm += std::pow(vectors[v * dimension + i], 2);
    }
  }
  return std::sqrt(error / norm);
}

TEST(Cpca, IsExactWhereComponentsReachTheRank) {
  const std::vector<float> vectors = affineFamilies(400, 5, 3);
  const Cpca cpca = clusteredPca(vectors, kDimension, {5, 3, 8});
  EXPECT_EQ(cpca.cluster_count, 5u);
  EXPECT_LT(reconstructionError(vectors, cpca), 1e-6);
  for (std::size_t v = 5; v < cpca.clusters.size(); ++v)
    EXPECT_EQ(cpca.clusters[v], cpca.clusters[v - 5]) << "families are told apart";
}

TEST(Cpca, IsExactWithAClusterAVector) {
  const std::vector<float> vectors = affineFamilies(20, 20, 2);
  const Cpca cpca = clusteredPca(vectors, kDimension, {64, 2, 3});
  EXPECT_EQ(cpca.cluster_count, 20u);
  EXPECT_EQ(reconstructionError(vectors, cpca), 0);
  for (const float weight : cpca.weights) EXPECT_EQ(weight, 0);
}

TEST(Cpca, ErrorFallsWithComponentsAndWithClusters) {
  const std::vector<float> vectors = affineFamilies(600, 4, 12);
  double last = 1;
  for (int components = 1; components <= 12; ++components) {
    const Cpca cpca = clusteredPca(vectors, kDimension, {4, components, 8});
    EXPECT_LT(cpca.relative_error, last) << components;
    EXPECT_NEAR(cpca.relative_error, reconstructionError(vectors, cpca), 1e-6);
    last = cpca.relative_error;
  }
  EXPECT_LT(last, 1e-6);
  last = 1;
  for (const int clusters : {1, 2, 4, 16, 64}) {
    const double error = clusteredPca(vectors, kDimension, {clusters, 3, 8}).relative_error;
    EXPECT_LT(error, last) << clusters;
    last = error;
  }
}

// One cluster is plain PCA: the error left is the tail of the eigenvalues of the covariance. Here the axes
// are the coordinates themselves.
TEST(Cpca, OfOneClusterIsPca) {
  const std::size_t dimension = 6;
  std::vector<float> vectors;
  double left = 0, norm = 0;
  for (std::size_t axis = 0; axis < dimension; ++axis)
    for (const int sign : {-1, 1})
      for (std::size_t i = 0; i < dimension; ++i) {
        const double value = i == axis ? sign * std::pow(2.0, -static_cast<double>(axis)) : 0;
        vectors.push_back(static_cast<float>(value));
        norm += value * value;
        if (axis >= 2) left += value * value;
      }
  const Cpca cpca = clusteredPca(vectors, dimension, {1, 2, 4});
  EXPECT_NEAR(cpca.relative_error, std::sqrt(left / norm), 1e-6);
  for (int k = 0; k < 2; ++k)
    for (std::size_t i = 0; i < dimension; ++i)
      EXPECT_NEAR(std::abs(cpca.basis[(1 + k) * dimension + i]), static_cast<int>(i) == k ? 1 : 0, 1e-6);
}

TEST(Cpca, GivesTheSameBytesWithAnyNumberOfThreads) {
  const std::vector<float> vectors = affineFamilies(1500, 7, 9);
  std::vector<Cpca> results;
  for (const std::size_t threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(clusteredPca(vectors, kDimension, {12, 4, 6}));
  }
  for (const Cpca& result : results) {
    EXPECT_EQ(result.basis, results[0].basis);
    EXPECT_EQ(result.weights, results[0].weights);
    EXPECT_EQ(result.clusters, results[0].clusters);
    EXPECT_EQ(result.relative_error, results[0].relative_error);
  }
}

TEST(Cpca, TakesIdenticalZeroAndSingleVectors) {
  const std::vector<float> one = affineFamilies(1, 1, 2);
  const std::vector<float> zero(10 * kDimension, 0.0f);
  std::vector<float> identical;
  for (int copy = 0; copy < 100; ++copy) identical.insert(identical.end(), one.begin(), one.end());
  for (const std::vector<float>& vectors : {one, identical, zero}) {
    const Cpca cpca = clusteredPca(vectors, kDimension, {8, 40, 2});
    EXPECT_EQ(cpca.cluster_count, 1u);
    EXPECT_EQ(cpca.components, 40) << "more than the dimension: the surplus is zero";
    EXPECT_EQ(cpca.weights.size(), vectors.size() / kDimension * 40);
    EXPECT_LT(cpca.relative_error, 1e-7);
    EXPECT_EQ(cpca.basis[0], vectors[0]);
    for (std::size_t i = kDimension; i < cpca.basis.size(); ++i) ASSERT_EQ(cpca.basis[i], 0);
  }
}

TEST(Cpca, CallsBackOnceARoundAndRefusesBadSizes) {
  const std::vector<float> vectors = affineFamilies(10, 2, 1);
  int rounds = 0;
  clusteredPca(vectors, kDimension, {2, 1, 7}, [&] { ++rounds; });
  EXPECT_EQ(rounds, 7);
  EXPECT_THROW(clusteredPca(vectors, 31, {}), std::invalid_argument);
  EXPECT_THROW(clusteredPca({}, kDimension, {}), std::invalid_argument);
  EXPECT_THROW(clusteredPca(vectors, kDimension, {0, 8, 12}), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::transfer
