#include "compression/harmonics.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <Eigen/Core>
#include <memory>
#include <numbers>

#include "formats/symbol_code.h"
#include "transport/cube_map.h"
#include "transport/hemisphere_grid.h"
#include "transport/sh.h"

namespace bakelight::compression {
namespace {

using Eigen::Index;
using Matrix = Eigen::MatrixXf;
using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct Harmonics {
  int order = 5;
  Rows light;    // texels × order²
  Matrix cells;  // cells × order²
  double cell_sr = 0;
  std::vector<Matrix> vertices;  // order² × order²
};

void evaluateInto(int order, const transport::Vec3& direction, Eigen::Ref<Eigen::RowVectorXf> row) {
  const std::vector<double> values = transport::evaluateSh(order, direction);
  for (Index i = 0; i < row.size(); ++i) row(i) = static_cast<float>(values[i]);
}

Harmonics bases(const formats::PixelCodes& codes, int order) {
  Harmonics result;
  result.order = order;
  const Index count = transport::coefficientCount(order);
  const int side = codes.cube_side, local = codes.local_side;
  result.light.resize(static_cast<Index>(codes.columnCount()), count);
  Eigen::RowVectorXf values(count);
  for (Index k = 0; k < result.light.rows(); ++k) {
    const int texel = static_cast<int>(k), x = texel % side, y = texel / side % side;
    evaluateInto(order,
                 transport::directionOfCubeFace(texel / side / side, (x + 0.5) / side, (y + 0.5) / side),
                 values);
    result.light.row(k) = values;
  }
  result.cells.resize(Index{local} * local, count);
  for (int row = 0; row < local; ++row)
    for (int column = 0; column < local; ++column) {
      evaluateInto(order, transport::hemisphereCell(local, column, row), values);
      result.cells.row(Index{row} * local + column) = values;
    }
  result.cell_sr = 2 * std::numbers::pi / (static_cast<double>(local) * local);
  return result;
}

Harmonics projected(const formats::PixelCodes& codes, int order) {
  Harmonics result = bases(codes, order);
  const Index cells = result.cells.rows();
  Rows weighted = result.light;
  const int side = codes.cube_side;
  const double scale = 1.0 / (static_cast<double>(codes.subsamples) * codes.subsamples);
  for (Index k = 0; k < weighted.rows(); ++k) {
    const int within = static_cast<int>(k) % (side * side);
    weighted.row(k) *=
        static_cast<float>(transport::cubeTexelSolidAngle(within % side, within / side, side) * scale);
  }
  result.vertices.resize(codes.rowCount() / cells);
  tbb::parallel_for(std::size_t{0}, result.vertices.size(), [&](std::size_t v) {
    Rows rows = Rows::Zero(cells, weighted.cols());
    for (Index cell = 0; cell < cells; ++cell) {
      const std::size_t row = v * cells + cell;
      for (std::uint64_t i = codes.row_offsets[row]; i < codes.row_offsets[row + 1]; ++i)
        rows.row(cell) += static_cast<float>(codes.codes[i]) * weighted.row(codes.columns[i]);
    }
    result.vertices[v] = result.cells.transpose() * rows;
  });
  return result;
}

// A stream for each pair of bands, as their sizes differ.
std::uint64_t bytesOf(const Harmonics& harmonics, float step) {
  std::uint64_t sum = 0;
  for (int row_band = 0; row_band < harmonics.order; ++row_band)
    for (int band = 0; band < harmonics.order; ++band) {
      std::vector<std::uint32_t> stream;
      for (const Matrix& matrix : harmonics.vertices)
        for (Index i = row_band * row_band; i < (row_band + 1) * (row_band + 1); ++i)
          for (Index j = band * band; j < (band + 1) * (band + 1); ++j)
            stream.push_back(formats::symbolOf(static_cast<std::int32_t>(std::lround(matrix(i, j) / step))));
      sum += formats::encodeSymbols(stream).size();
    }
  return sum;
}

void multiply(const Harmonics& harmonics, std::span<const Radiance4> light, std::span<Radiance4> values) {
  const Index count = harmonics.light.cols(), cells = harmonics.cells.rows();
  Eigen::MatrixXd colors = Eigen::MatrixXd::Zero(count, 4);
  for (std::size_t k = 0; k < light.size(); ++k)
    colors += (harmonics.light.row(static_cast<Index>(k)).transpose() * light[k].transpose()).cast<double>();
  const Matrix coefficients = colors.cast<float>();
  const auto cell_sr = static_cast<float>(harmonics.cell_sr);
  tbb::parallel_for(std::size_t{0}, harmonics.vertices.size(), [&](std::size_t v) {
    const Matrix incident =
        harmonics.cells.lazyProduct(Matrix(harmonics.vertices[v].lazyProduct(coefficients)));
    for (Index cell = 0; cell < cells; ++cell)
      values[v * cells + cell] = incident.row(cell).transpose() * cell_sr;
  });
}

}  // namespace

CompressedTransfer harmonicsWithin(std::uint64_t budget, const formats::PixelCodes& codes, int order) {
  Harmonics harmonics = projected(codes, order);
  const auto stepAt = [](double position) {
    constexpr double kOctaves = 20;
    return static_cast<float>(64 * std::exp2(kOctaves * (position - 1)));
  };
  const Solved solved =
      solveForBytes([&](double position) { return bytesOf(harmonics, stepAt(position)); }, budget);
  const float step = stepAt(solved.at);
  for (Matrix& matrix : harmonics.vertices)
    matrix = matrix.unaryExpr([&](float value) { return std::round(value / step) * step; });

  const auto result = std::make_shared<const Harmonics>(std::move(harmonics));
  const auto count = static_cast<std::uint64_t>(transport::coefficientCount(order)),
             vertices = static_cast<std::uint64_t>(result->vertices.size()),
             cells = static_cast<std::uint64_t>(result->cells.rows());
  CompressedTransfer transfer;
  transfer.name = "harmonics";
  transfer.parameters = "order " + std::to_string(order);
  transfer.bytes = solved.bytes;
  transfer.operations = 2 * (codes.columnCount() * count + vertices * count * (count + cells));
  transfer.value_count = codes.rowCount();
  transfer.multiply = [result](std::span<const Radiance4> light, std::span<Radiance4> values) {
    multiply(*result, light, values);
  };
  return transfer;
}

}  // namespace bakelight::compression
