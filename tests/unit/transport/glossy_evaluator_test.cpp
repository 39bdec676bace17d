#include "transport/glossy_evaluator.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>
#include <tbb/global_control.h>

#include <cmath>
#include <stdexcept>

#include "transport/triple_product.h"

namespace bakelight::transport {
namespace {

using formats::MatrixStorage;
using formats::Precision;
using formats::RadianceTransfer;

class Numbers {
 public:
  explicit Numbers(unsigned seed) : state_(seed) {}
  float next() {
    state_ = state_ * 1664525u + 1013904223u;
    return static_cast<float>(state_ >> 8) / static_cast<float>(1 << 23) - 1;
  }
  std::vector<float> many(std::size_t count) {
    std::vector<float> values(count);
    for (float& value : values) value = next();
    return values;
  }

 private:
  unsigned state_;
};

struct Case {
  MatrixStorage storage;
  Precision precision;
  int channels, row_order, order;
  std::size_t vertices;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << nameOf(c.storage) << " " << nameOf(c.precision) << ", " << c.channels << " channels, "
       << c.row_order << " × " << c.order << ", " << c.vertices << " vertices";
}

constexpr std::size_t kClusters = 3, kComponents = 5;

RadianceTransfer someTransfer(const Case& c) {
  Numbers numbers(17);
  RadianceTransfer transfer;
  transfer.order = c.order;
  transfer.row_order = c.row_order;
  transfer.channels = c.channels;
  transfer.storage = c.storage;
  const std::size_t cells = c.channels * coefficientCount(c.row_order) * coefficientCount(c.order);
  const auto encode = [&](std::size_t rows, std::size_t columns) {
    return formats::encodeTable(numbers.many(rows * columns), columns, c.precision, "test", "numbers");
  };
  if (c.storage == MatrixStorage::kMatrix) transfer.matrices = encode(c.vertices, cells);
  if (c.storage == MatrixStorage::kVisibility)
    transfer.matrices = encode(c.vertices, coefficientCount(c.row_order + c.order - 1));
  if (c.storage == MatrixStorage::kCpca) {
    transfer.matrices = encode(c.vertices, kComponents);
    transfer.basis = encode(kClusters * (1 + kComponents), cells);
    for (std::size_t v = 0; v < c.vertices; ++v)
      transfer.clusters.push_back(static_cast<std::uint32_t>(v * v % 7 % kClusters));
  }
  return transfer;
}

// Matrix of a vertex in double precision: [channel][i][j].
std::vector<double> matrixOf(const RadianceTransfer& transfer, const std::vector<float>& table,
                             const std::vector<float>& basis, std::size_t vertex) {
  const std::size_t cells = coefficientCount(transfer.row_order) * coefficientCount(transfer.order);
  const float* row = &table[vertex * transfer.matrices.columns];
  std::vector<double> matrix(transfer.channels * cells, 0.0);
  if (transfer.storage == MatrixStorage::kMatrix) matrix.assign(row, row + matrix.size());
  if (transfer.storage == MatrixStorage::kVisibility) {
    const TripleProduct product(transfer.row_order, transfer.order);
    for (const auto& entry : product.entries())
      matrix[entry.i * coefficientCount(transfer.order) + entry.j] += double{entry.value} * row[entry.k];
  }
  if (transfer.storage == MatrixStorage::kCpca)
    for (std::size_t member = 0; member <= kComponents; ++member)
      for (std::size_t cell = 0; cell < matrix.size(); ++cell)
        matrix[cell] +=
            (member == 0 ? 1.0 : row[member - 1]) *
            basis[(transfer.clusters[vertex] * (1 + kComponents) + member) * matrix.size() + cell];
  return matrix;
}

// Rows given as coefficients × vertices, in the order that the evaluator asks for.
std::vector<float> inTiles(const GlossyEvaluator& evaluator, std::span<const float> rows,
                           std::size_t vertices) {
  constexpr std::size_t kTile = GlossyEvaluator::kTile;
  const auto order = evaluator.vertexOrder();
  const std::size_t count = rows.size() / vertices;
  std::vector<float> tiles(order.size() * count);
  for (std::size_t place = 0; place < order.size(); ++place)
    for (std::size_t i = 0; i < count; ++i)
      tiles[(place / kTile * count + i) * kTile + place % kTile] = rows[i * vertices + order[place]];
  return tiles;
}

class GlossyEvaluatorCases : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    Numbers numbers(5);
    for (int j = 0; j < coefficientCount(GetParam().order); ++j)
      light_.push_back({numbers.next(), numbers.next(), numbers.next()});
    rows_ = numbers.many(coefficientCount(GetParam().row_order) * GetParam().vertices);
  }

  std::vector<Float3> light_;
  std::vector<float> rows_;
};

// The kernels of every instruction set of this machine against plain sums in double precision.
TEST_P(GlossyEvaluatorCases, EqualsPlainSums) {
  const RadianceTransfer transfer = someTransfer(GetParam());
  const std::size_t rows = coefficientCount(transfer.row_order), columns = coefficientCount(transfer.order);
  const std::size_t count = GetParam().vertices;
  const std::vector<float> table = transfer.matrices.decode(), basis = transfer.basis.decode();
  std::vector<std::array<double, 3>> transferred(count * rows), radiance(count);
  for (std::size_t v = 0; v < count; ++v) {
    const std::vector<double> matrix = matrixOf(transfer, table, basis, v);
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < rows; ++i) {
        double sum = 0;
        for (std::size_t j = 0; j < columns; ++j)
          sum += matrix[((transfer.channels == 3 ? c : 0) * rows + i) * columns + j] * light_[j][c];
        transferred[v * rows + i][c] = sum;
        radiance[v][c] += sum * rows_[i * count + v];
      }
  }

  // Roundings of single precision over the sums' terms, all of about one.
  const double tolerance = 2e-6 * std::sqrt(static_cast<double>(rows * columns)) * 10;
  int targets = 0;
  for (std::int64_t left = hwy::SupportedTargets() & HWY_TARGETS; left != 0; left &= left - 1, ++targets) {
    hwy::SetSupportedTargetsForTest(left & -left);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    const std::string target = hwy::TargetName(left & -left);
    const GlossyEvaluator evaluator(transfer);
    std::vector<Float3> shaded(count);
    evaluator.shade(light_, inTiles(evaluator, rows_, GetParam().vertices), shaded);
    const std::vector<Float3> found = evaluator.transferredRadiance(light_);
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    ASSERT_EQ(found.size(), transferred.size());
    for (std::size_t e = 0; e < found.size(); ++e)
      for (std::size_t c = 0; c < 3; ++c)
        ASSERT_NEAR(found[e][c], transferred[e][c], tolerance)
            << target << ", entry " << e << ", colour " << c;
    for (std::size_t v = 0; v < count; ++v)
      for (std::size_t c = 0; c < 3; ++c)
        ASSERT_NEAR(shaded[v][c], radiance[v][c], tolerance)
            << target << ", vertex " << v << ", colour " << c;
  }
  EXPECT_GT(targets, 0);
}

TEST_P(GlossyEvaluatorCases, GivesTheSameBytesWithAnyNumberOfThreads) {
  const GlossyEvaluator evaluator(someTransfer(GetParam()));
  std::vector<Float3> one(GetParam().vertices), many(one.size());
  std::vector<Float3> one_transferred;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    evaluator.shade(light_, inTiles(evaluator, rows_, GetParam().vertices), one);
    one_transferred = evaluator.transferredRadiance(light_);
  }
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 5);
  evaluator.shade(light_, inTiles(evaluator, rows_, GetParam().vertices), many);
  EXPECT_EQ(one, many);
  EXPECT_EQ(one_transferred, evaluator.transferredRadiance(light_));
}

TEST_P(GlossyEvaluatorCases, IsBlackWithoutLight) {
  const GlossyEvaluator evaluator(someTransfer(GetParam()));
  std::vector<Float3> radiance(GetParam().vertices, Float3{1, 1, 1});
  evaluator.shade(std::vector<Float3>(light_.size()), inTiles(evaluator, rows_, GetParam().vertices),
                  radiance);
  for (const Float3& color : radiance) EXPECT_EQ(color, (Float3{0, 0, 0}));
}

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const auto storage : {MatrixStorage::kMatrix, MatrixStorage::kVisibility, MatrixStorage::kCpca})
    for (const auto precision : {Precision::kFloat32, Precision::kFloat16, Precision::kUint8}) {
      all.push_back({storage, precision, 1, 5, 5, 100});
      all.push_back({storage, precision, 1, 5, 3, 33});
      all.push_back({storage, precision, 1, 2, 4, 16});
      all.push_back({storage, precision, 1, 1, 1, 1});
      all.push_back({storage, precision, 1, 7, 6, 17});
      if (storage != MatrixStorage::kVisibility) all.push_back({storage, precision, 3, 5, 4, 50});
    }
  for (const auto storage : {MatrixStorage::kMatrix, MatrixStorage::kVisibility, MatrixStorage::kCpca})
    for (const int order : {3, 4, 8, 9, 10})
      all.push_back({storage, Precision::kFloat32, 1, order, order, 20});
  return all;
}

INSTANTIATE_TEST_SUITE_P(Storages, GlossyEvaluatorCases, testing::ValuesIn(cases()));

TEST(GlossyEvaluator, TellsWhatItReads) {
  RadianceTransfer transfer = someTransfer({MatrixStorage::kMatrix, Precision::kFloat16, 1, 5, 5, 40});
  const GlossyEvaluator matrix(transfer);
  EXPECT_EQ(matrix.tableBytes(), 40u * 625 * 2);
  EXPECT_EQ(matrix.multiplyAdds(), 40 * (625 + 75));
  const GlossyEvaluator cpca(someTransfer({MatrixStorage::kCpca, Precision::kFloat32, 1, 5, 5, 40}));
  EXPECT_EQ(cpca.tableBytes(), 40u * (kComponents + 1) * 4 + kClusters * (1 + kComponents) * 625 * 4);
}

TEST(GlossyEvaluator, RefusesWhatDoesNotFit) {
  EXPECT_THROW(GlossyEvaluator{RadianceTransfer{}}, std::invalid_argument);
  RadianceTransfer transfer = someTransfer({MatrixStorage::kMatrix, Precision::kUint8, 1, 3, 3, 10});
  RadianceTransfer wrong = transfer;
  wrong.row_order = 2;
  EXPECT_THROW(GlossyEvaluator{wrong}, std::invalid_argument);
  wrong = someTransfer({MatrixStorage::kCpca, Precision::kFloat32, 1, 3, 3, 10});
  wrong.clusters[4] = kClusters;
  EXPECT_THROW(GlossyEvaluator{wrong}, std::invalid_argument);
  const GlossyEvaluator evaluator(transfer);
  std::vector<Float3> radiance(10);
  const std::vector<float> rows(9 * 16);
  EXPECT_THROW(evaluator.shade(std::vector<Float3>(8), rows, radiance), std::invalid_argument);
  EXPECT_THROW(evaluator.shade(std::vector<Float3>(9), std::vector<float>(9 * 10), radiance),
               std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::transport
