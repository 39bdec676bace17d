#include "tools/atlas/flatten/pair_laplacian.h"

#include <algorithm>

namespace bakelight::atlas {
namespace {

constexpr double kRegularization = 1e-8;  // of the mean diagonal

// Row and column of the six entries of a group's lower triangle.
constexpr std::array<std::array<std::size_t, 2>, 6> kLower = {
    {{0, 0}, {1, 0}, {1, 1}, {2, 0}, {2, 1}, {2, 2}}};

}  // namespace

void PairLaplacian::setPattern(std::size_t vertices, std::span<const Group> groups) {
  const auto placeOf = [](const Group& group, const std::array<std::size_t, 2>& entry) {
    const auto a = static_cast<int>(group[entry[0]]), b = static_cast<int>(group[entry[1]]);
    return std::pair(std::max(a, b), std::min(a, b));
  };
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(6 * groups.size());
  for (const Group& group : groups)
    for (const auto& entry : kLower) {
      const auto [row, column] = placeOf(group, entry);
      entries.emplace_back(row, column, 0.0);
    }
  const auto size = static_cast<Eigen::Index>(vertices);
  matrix_.resize(size, size);
  matrix_.setFromTriplets(entries.begin(), entries.end());
  matrix_.makeCompressed();
  slots_.clear();
  slots_.reserve(groups.size());
  for (const Group& group : groups) {
    auto& slots = slots_.emplace_back();
    for (std::size_t i = 0; i < kLower.size(); ++i) {
      const auto [row, column] = placeOf(group, kLower[i]);
      const int* begin = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[column];
      const int* end = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[column + 1];
      slots[i] = static_cast<int>(std::lower_bound(begin, end, row) - matrix_.innerIndexPtr());
    }
  }
  is_analyzed_ = false;
  ordered_.resize(vertices);
}

void PairLaplacian::begin() {
  std::fill_n(matrix_.valuePtr(), matrix_.nonZeros(), 0.0);
}

void PairLaplacian::add(std::size_t group, const std::array<double, 6>& lower) {
  for (std::size_t i = 0; i < lower.size(); ++i) matrix_.valuePtr()[slots_[group][i]] += lower[i];
}

bool PairLaplacian::factorize() {
  const double shift = kRegularization * matrix_.diagonal().mean();
  // The diagonal is the first entry of each column.
  for (Eigen::Index v = 0; v < matrix_.cols(); ++v) matrix_.valuePtr()[matrix_.outerIndexPtr()[v]] += shift;
  if (!is_analyzed_) factor_.analyzePattern(matrix_), is_analyzed_ = true;
  factor_.factorize(matrix_);
  return factor_.info() == Eigen::Success;
}

// Eigen's own substitution takes one column after the other, twice the way through the factor.
void PairLaplacian::solve(const Eigen::VectorXd& right, Eigen::VectorXd& solution) {
  const Eigen::SparseMatrix<double>& lower = factor_.matrixL().nestedExpression();
  const int *outer = lower.outerIndexPtr(), *rows = lower.innerIndexPtr();
  const double* values = lower.valuePtr();
  const auto& order = factor_.permutationP().indices();
  const Eigen::Index size = lower.cols();
  for (Eigen::Index v = 0; v < size; ++v) ordered_[order[v]] = {right[2 * v], right[2 * v + 1]};
  for (Eigen::Index c = 0; c < size; ++c) {
    const Vec2 x = ordered_[c] /= values[outer[c]];
    for (int i = outer[c] + 1; i < outer[c + 1]; ++i) ordered_[rows[i]] -= values[i] * x;
  }
  for (Eigen::Index c = size - 1; c >= 0; --c) {
    Vec2 x = ordered_[c];
    for (int i = outer[c] + 1; i < outer[c + 1]; ++i) x -= values[i] * ordered_[rows[i]];
    ordered_[c] = x / values[outer[c]];
  }
  for (Eigen::Index v = 0; v < size; ++v) {
    solution[2 * v] = ordered_[order[v]].x();
    solution[2 * v + 1] = ordered_[order[v]].y();
  }
}

}  // namespace bakelight::atlas
