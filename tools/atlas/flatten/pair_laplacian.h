// A scalar operator on the vertices of a chart, applied to both coordinates at once.
#pragma once

#include <Eigen/SparseCholesky>

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "tools/atlas/charts/surface.h"

namespace bakelight::atlas {

// Symmetric and positive: sums of small symmetric matrices over groups of three vertices. The pattern and its
// elimination order are found once, then values may change.
class PairLaplacian {
 public:
  using Group = std::array<std::uint32_t, 3>;

  void setPattern(std::size_t vertices, std::span<const Group> groups);
  // In the order of the groups: the matrix's lower triangle, by rows.
  void begin();
  void add(std::size_t group, const std::array<double, 6>& lower);
  // A little of the mean diagonal is added, as constants are in the Laplacian's kernel. Whether it could be
  // factorised.
  bool factorize();

  // solution = operator⁻¹ · right, of pairs of numbers, one pair a vertex.
  void solve(const Eigen::VectorXd& right, Eigen::VectorXd& solution);

 private:
  Eigen::SparseMatrix<double> matrix_;  // lower triangle
  std::vector<std::array<int, 6>> slots_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
  bool is_analyzed_ = false;
  std::vector<Vec2> ordered_;
};

}  // namespace bakelight::atlas
