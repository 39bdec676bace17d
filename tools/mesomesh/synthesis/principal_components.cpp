#include "tools/mesomesh/synthesis/principal_components.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include "transport/random.h"

namespace bakelight::mesomesh {
namespace {

constexpr Eigen::Index kMostExactDimensions = 160;
constexpr int kSpareDirections = 8;
constexpr int kMostIterations = 30;
constexpr double kStandsStill = 1e-5;  // share of the variance
// Below this share of the variance a component is rounding.
constexpr double kLeastShare = 1e-10;

struct Directions {
  Eigen::MatrixXd axes;       // dimensions × directions, orthonormal
  Eigen::VectorXd variances;  // falling
};

Directions fallingEigenpairs(const Eigen::MatrixXd& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(symmetric);
  return {solver.eigenvectors().rowwise().reverse(), solver.eigenvalues().reverse()};
}

Directions exactDirections(const Samples& samples) {
  const Eigen::MatrixXd wide = samples.cast<double>();
  return fallingEigenpairs(wide.transpose() * wide);
}

Directions iteratedDirections(const Samples& samples, int count, double total) {
  const Eigen::Index dimensions = samples.cols();
  Eigen::MatrixXf axes(dimensions, std::min<Eigen::Index>(count + kSpareDirections, dimensions));
  for (Eigen::Index i = 0; i < axes.size(); ++i) {
    const std::uint64_t bits = transport::scrambled(static_cast<std::uint64_t>(i));
    axes.data()[i] = static_cast<float>(static_cast<double>(bits >> 40) * 0x1p-23 - 1);
  }
  double retained = 0;
  for (int iteration = 0;; ++iteration) {
    axes = Eigen::HouseholderQR<Eigen::MatrixXf>(axes).householderQ() *
           Eigen::MatrixXf::Identity(dimensions, axes.cols());
    const Eigen::MatrixXf scores = samples * axes;
    const Eigen::MatrixXd wide = scores.cast<double>();
    const Directions within = fallingEigenpairs(wide.transpose() * wide);
    const double retained_now = within.variances.head(std::min<Eigen::Index>(count, axes.cols())).sum();
    if (iteration == kMostIterations || retained_now - retained <= kStandsStill * total)
      return {axes.cast<double>() * within.axes, within.variances};
    retained = retained_now;
    axes = samples.transpose() * scores;
  }
}

}  // namespace

PrincipalComponents principalComponents(Samples samples, int count) {
  PrincipalComponents result;
  result.mean = samples.cast<double>().colwise().mean().cast<float>();
  const double magnitude = samples.cast<double>().squaredNorm();
  samples.rowwise() -= result.mean;
  const double total = samples.cast<double>().squaredNorm();
  // What is left of a constant is the rounding of its mean.
  if (!(total > 1e-12 * magnitude)) {
    result.axes = Eigen::MatrixXf::Zero(samples.cols(), 1);
    return result;
  }
  const Directions directions = samples.cols() <= kMostExactDimensions
                                    ? exactDirections(samples)
                                    : iteratedDirections(samples, count, total);
  Eigen::Index kept = 0;
  while (kept < std::min<Eigen::Index>(count, directions.variances.size()) &&
         directions.variances[kept] > kLeastShare * total)
    ++kept;
  result.axes = directions.axes.leftCols(kept).cast<float>();
  result.retained_variance = std::min(1.0, directions.variances.head(kept).sum() / total);
  return result;
}

}  // namespace bakelight::mesomesh
