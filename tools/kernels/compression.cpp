#include "tools/kernels/compression.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>

namespace bakelight::kernels {
namespace {

using RowsOfFloats = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
constexpr Eigen::Index kBlock = 2048;

}  // namespace

CompressedKernels compress(const std::vector<float>& rows, std::size_t columns, double error) {
  const auto width = static_cast<Eigen::Index>(columns);
  const Eigen::Index height = static_cast<Eigen::Index>(rows.size()) / width;
  const Eigen::Map<const RowsOfFloats> all(rows.data(), height, width);
  // Blocks are added in their order, whichever thread made them.
  const Eigen::Index blocks = (height + kBlock - 1) / kBlock;
  std::vector<Eigen::MatrixXd> partial(static_cast<std::size_t>(blocks));
  tbb::parallel_for(Eigen::Index{0}, blocks, [&](Eigen::Index b) {
    const Eigen::MatrixXd block =
        all.middleRows(b * kBlock, std::min(kBlock, height - b * kBlock)).cast<double>();
    partial[static_cast<std::size_t>(b)] = block.transpose() * block;
  });
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(width, width);
  for (const Eigen::MatrixXd& part : partial) gram += part;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram);
  const double total = solver.eigenvalues().cwiseMax(0).sum();

  CompressedKernels result;
  double left = total;
  Eigen::Index components = 0;
  while (components < width && left > error * error * total)
    left -= std::max(solver.eigenvalues()[width - 1 - components++], 0.0);
  if (total == 0 || height * components + components * width >= height * width) return result;
  result.components = static_cast<int>(components);
  result.error = std::sqrt(std::max(left, 0.0) / total);
  const RowsOfFloats basis =
      solver.eigenvectors().rightCols(components).rowwise().reverse().transpose().cast<float>();
  result.basis.assign(basis.data(), basis.data() + basis.size());
  result.weights.resize(static_cast<std::size_t>(height * components));
  Eigen::Map<RowsOfFloats> weights(result.weights.data(), height, components);
  tbb::parallel_for(Eigen::Index{0}, blocks, [&](Eigen::Index b) {
    const Eigen::Index first = b * kBlock, count = std::min(kBlock, height - first);
    weights.middleRows(first, count) = all.middleRows(first, count) * basis.transpose();
  });
  return result;
}

}  // namespace bakelight::kernels
