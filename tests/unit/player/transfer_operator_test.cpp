#include "tools/player/operators/transfer_operator.h"

#include <cmath>

#include "tests/support/pack_parts.h"
#include "tests/unit/player/random_values.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/lights/gpu_light.h"
#include "transport/triple_product.h"

namespace bakelight::player {
namespace {

using formats::Precision;
using formats::Storage;
using transport::Float3;

constexpr std::size_t kVertices = 301;  // no multiple of the work group, nor of a word's bytes

formats::EncodedTable randomTable(std::size_t rows, std::size_t columns, Precision precision, unsigned seed) {
  return formats::encodeTable(randomValues(rows * columns, seed), columns, precision, "made", "table");
}

std::size_t squared(int order) {
  return static_cast<std::size_t>(transport::coefficientCount(order));
}

formats::ShTransfer randomTransfer(Storage storage, int row_order, int order, int channels,
                                   Precision precision) {
  constexpr std::size_t kClusters = 7, kWeights = 3;
  formats::ShTransfer transfer;
  transfer.order = order;
  makeGlossy(transfer, storage, row_order);
  transfer.channels = channels;
  const std::size_t size = channels * squared(row_order) * squared(order);
  if (storage == Storage::kMatrix)
    transfer.glossy->vertexTable() = randomTable(kVertices, size, precision, 1);
  if (storage == Storage::kVisibility)
    transfer.glossy->vertexTable() = randomTable(kVertices, squared(row_order + order - 1), precision, 2);
  if (storage == Storage::kCpca) {
    transfer.glossy->vertexTable() = randomTable(kVertices, kWeights, precision, 3);
    clustersOf(transfer).basis = randomTable(kClusters * (1 + kWeights), size, precision, 4);
    for (std::size_t v = 0; v < kVertices; ++v)
      clustersOf(transfer).clusters.push_back(static_cast<std::uint32_t>((5 * v) % kClusters));
  }
  return transfer;
}

transport::ShLight randomLight(int order) {
  const auto values = randomValues(3 * squared(order), 5);
  transport::ShLight light;
  for (std::size_t i = 0; i < squared(order); ++i)
    light.push_back({values[3 * i], 10 * values[3 * i + 1], 0.1f * values[3 * i + 2]});
  return light;
}

// row_order² × RGB of one row of matrices.
std::vector<double> timesLight(const formats::ShTransfer& transfer, const float* row,
                               const transport::ShLight& light) {
  const std::size_t rows = squared(transfer.glossy->output_order), columns = squared(transfer.order);
  std::vector<double> result(rows * 3);
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t j = 0; j < columns; ++j) {
        const std::size_t channel = transfer.channels == 3 ? c : 0;
        result[3 * i + c] += static_cast<double>(row[(channel * rows + i) * columns + j]) * light[j][c];
      }
  return result;
}

std::vector<double> expectedOfVertex(const formats::ShTransfer& transfer, std::size_t v,
                                     const transport::ShLight& light) {
  const auto table = transfer.glossy->vertexTable().decode();
  const float* row = &table[v * transfer.glossy->vertexTable().columns];
  if (storageOf(transfer) == Storage::kMatrix) return timesLight(transfer, row, light);
  if (storageOf(transfer) == Storage::kVisibility) {
    const transport::TripleProduct product(transfer.glossy->output_order, transfer.order);
    std::vector<float> matrix(squared(transfer.glossy->output_order) * squared(transfer.order));
    product.matrixOf({row, transfer.glossy->vertexTable().columns}, matrix);
    return timesLight(transfer, matrix.data(), light);
  }
  const auto& clustered = std::get<formats::ClusteredOperator>(transfer.glossy->transfer);
  const auto basis = clustered.basis.decode();
  std::vector<double> sum(3 * squared(transfer.glossy->output_order));
  const std::size_t weights = transfer.glossy->vertexTable().columns;
  for (std::size_t k = 0; k <= weights; ++k) {
    const std::size_t basis_row = clustered.clusters[v] * (1 + weights) + k;
    const auto part = timesLight(transfer, &basis[basis_row * clustered.basis.columns], light);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += (k == 0 ? 1 : row[k - 1]) * part[i];
  }
  return sum;
}

std::vector<float> evaluate(const formats::ShTransfer& transfer, const transport::ShLight& light,
                            std::size_t largest_block_bytes = 0) {
  const auto transfer_operator = makeTransferOperator(transfer, largest_block_bytes);
  GpuLight gpu_light = darkLight();
  setLight(gpu_light, light);
  transfer_operator->evaluate(gpu_light.sh);
  std::vector<float> result(kVertices * 3 * squared(transfer.glossy->output_order));
  glGetNamedBufferSubData(transfer_operator->transferred().name(), 0,
                          static_cast<GLsizeiptr>(result.size() * sizeof(float)), result.data());
  throwIfGlFailed("reading back");
  return result;
}

struct Shape {
  int row_order, order;
};

class TransferOperatorTest : public testing::Test {
 protected:
  HeadlessContext context_;
};

TEST_F(TransferOperatorTest, IsMatrixTimesLightForEachStorageAndPrecision) {
  for (const auto storage : {Storage::kMatrix, Storage::kVisibility, Storage::kCpca})
    for (const auto precision : {Precision::kFloat32, Precision::kFloat16, Precision::kUint8})
      for (const Shape shape : {Shape{1, 1}, Shape{5, 5}, Shape{5, 3}, Shape{2, 4}})
        for (const int channels : {1, 3}) {
          if (storage == Storage::kVisibility && channels == 3) continue;
          const auto transfer = randomTransfer(storage, shape.row_order, shape.order, channels, precision);
          const auto light = randomLight(shape.order);
          const auto actual = evaluate(transfer, light);
          for (std::size_t v = 0; v < kVertices; v += 50) {
            const auto expected = expectedOfVertex(transfer, v, light);
            for (std::size_t i = 0; i < expected.size(); ++i)
              ASSERT_NEAR(actual[v * expected.size() + i], expected[i], 2e-4)
                  << nameOf(storage) << ' ' << nameOf(precision) << ' ' << shape.row_order << " by "
                  << shape.order << ' ' << channels << " vertex " << v << " value " << i;
          }
        }
}

TEST_F(TransferOperatorTest, OrderTen) {
  const auto light = randomLight(10);
  for (const auto storage : {Storage::kMatrix, Storage::kVisibility}) {
    const auto transfer = randomTransfer(storage, 10, 10, 1, Precision::kFloat16);
    const auto actual = evaluate(transfer, light);
    const auto expected = expectedOfVertex(transfer, 300, light);
    for (std::size_t i = 0; i < 300; ++i) ASSERT_NEAR(actual[300 * 300 + i], expected[i], 1e-3) << i;
  }
}

TEST_F(TransferOperatorTest, PiecesGiveTheSameAsTheWholeTable) {
  const auto light = randomLight(5);
  for (const auto storage : {Storage::kMatrix, Storage::kVisibility, Storage::kCpca}) {
    const auto transfer = randomTransfer(storage, 5, 5, 1, Precision::kUint8);
    EXPECT_GT(makeTransferOperator(transfer, 1000)->dispatchCount(),
              makeTransferOperator(transfer)->dispatchCount())
        << "nothing was cut";
    EXPECT_EQ(evaluate(transfer, light, 1000), evaluate(transfer, light)) << nameOf(storage);
  }
}

TEST_F(TransferOperatorTest, TablesThatDoNotFitAreRefused) {
  auto transfer = randomTransfer(Storage::kCpca, 2, 2, 1, Precision::kFloat32);
  clustersOf(transfer).clusters[17] = 7;
  EXPECT_THROW(makeTransferOperator(transfer), std::invalid_argument);
  transfer = randomTransfer(Storage::kMatrix, 2, 2, 1, Precision::kFloat32);
  transfer.glossy->output_order = 3;
  EXPECT_THROW(makeTransferOperator(transfer), std::invalid_argument);
  transfer.glossy.reset();
  EXPECT_THROW(makeTransferOperator(transfer), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::player
