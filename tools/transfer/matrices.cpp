#include "tools/transfer/matrices.h"

#include <array>
#include <Eigen/Core>

namespace bakelight::transfer {

namespace {
using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
}

MatrixBaker::MatrixBaker(int row_order, int order)
    : row_order_(row_order), order_(order), product_(row_order, order) {}

void MatrixBaker::fromVisibility(std::span<const float> visibility, std::span<float> matrix) const {
  product_.matrixOf(visibility, matrix);
}

void MatrixBaker::turnRows(const Eigen::Matrix3d& local_from_object, std::span<float> matrix) const {
  const transport::ShRotation rotation(row_order_, local_from_object);
  const int columns = transport::coefficientCount(order_);
  Eigen::Map<RowMajor> rows(matrix.data(), transport::coefficientCount(row_order_), columns);
  for (int l = 1; l < row_order_; ++l) {
    auto band = rows.middleRows(l * l, 2 * l + 1);
    band = (rotation.band(l) * band.cast<double>()).cast<float>().eval();
  }
}

void addBouncedLight(const ShadowPass& pass, const SurfacePoint& point, const std::vector<bool>& blocked_rays,
                     const transport::TransferField& exit,
                     std::span<const formats::Triangle> sides_from_behind,
                     std::span<const std::uint32_t> row_of_side, int channels, int row_order, int order,
                     double share, ShadowPass::Workspace& work, std::span<float> matrices) {
  const int rows = transport::coefficientCount(row_order), columns = transport::coefficientCount(order);
  const int width = channels * columns;
  pass.findHits(point, blocked_rays, work);

  // Hits in blocks, so that the sum over them is a product of two small matrices.
  constexpr int kBlock = 128;
  RowMajor basis = RowMajor::Zero(kBlock, rows), bounced = RowMajor::Zero(kBlock, width);
  RowMajor sum = RowMajor::Zero(rows, width);
  int filled = 0;
  const auto flush = [&] {
    sum.noalias() += basis.topRows(filled).transpose() * bounced.topRows(filled);
    filled = 0;
  };
  for (std::size_t k = 0; k < work.blocked_directions.size(); ++k) {
    if (work.hits.blocked[k] == 0) continue;
    const std::uint32_t triangle = work.hits.triangle[k];
    const formats::Triangle& corners =
        work.hits.back_face[k] != 0 ? sides_from_behind[triangle] : pass.mesh().triangles[triangle];
    if (corners[0] == kDarkSide) continue;
    const float u = work.hits.u[k], v = work.hits.v[k];
    const std::array<float, 3> shares = {1 - u - v, u, v};
    bounced.row(filled).setZero();
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t row = row_of_side[corners[corner]];
      if (row == kDarkSide) continue;  // a back that no vertex saw
      bounced.row(filled) +=
          shares[corner] * Eigen::Map<const Eigen::RowVectorXf>(exit.row(row).data(), width);
    }
    basis.row(filled) =
        Eigen::Map<const Eigen::RowVectorXf>(pass.quadrature().row(work.blocked_directions[k]), rows);
    if (++filled == kBlock) flush();
  }
  flush();
  const auto weight = static_cast<float>(share * pass.quadrature().weight());
  for (int c = 0; c < channels; ++c)
    Eigen::Map<RowMajor>(matrices.data() + static_cast<std::ptrdiff_t>(c) * rows * columns, rows, columns) +=
        weight * sum.middleCols(static_cast<Eigen::Index>(c) * columns, columns);
}

}  // namespace bakelight::transfer
