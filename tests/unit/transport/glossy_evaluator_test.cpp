#include "transport/glossy_evaluator.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>
#include <tbb/global_control.h>

#include <cmath>
#include <stdexcept>

#include "tests/support/pack_parts.h"
#include "transport/triple_product.h"

namespace bakelight::transport {
namespace {

using formats::Precision;
using formats::ShTransfer;
using formats::Storage;

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
  Storage storage;
  Precision precision;
  int channels, row_order, order;
  std::size_t vertices;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << nameOf(c.storage) << " " << nameOf(c.precision) << ", " << c.channels << " channels, "
       << c.row_order << " × " << c.order << ", " << c.vertices << " vertices";
}

constexpr std::size_t kClusters = 3, kComponents = 5;

ShTransfer someTransfer(const Case& c) {
  Numbers numbers(17);
  ShTransfer transfer;
  transfer.order = c.order;
  transfer.channels = c.channels;
  makeGlossy(transfer, c.storage, c.row_order);
  const std::size_t cells = c.channels * coefficientCount(c.row_order) * coefficientCount(c.order);
  const auto encode = [&](std::size_t rows, std::size_t columns) {
    return formats::encodeTable(numbers.many(rows * columns), columns, c.precision, "test", "numbers");
  };
  if (c.storage == Storage::kMatrix) transfer.glossy->vertexTable() = encode(c.vertices, cells);
  if (c.storage == Storage::kVisibility)
    transfer.glossy->vertexTable() = encode(c.vertices, coefficientCount(c.row_order + c.order - 1));
  if (c.storage == Storage::kCpca) {
    transfer.glossy->vertexTable() = encode(c.vertices, kComponents);
    clustersOf(transfer).basis = encode(kClusters * (1 + kComponents), cells);
    for (std::size_t v = 0; v < c.vertices; ++v)
      clustersOf(transfer).clusters.push_back(static_cast<std::uint32_t>(v * v % 7 % kClusters));
  }
  return transfer;
}

// Matrix of a vertex in double precision: [channel][i][j].
std::vector<double> matrixOf(const ShTransfer& transfer, const std::vector<float>& table,
                             const std::vector<float>& basis, std::size_t vertex) {
  const std::size_t cells =
      coefficientCount(transfer.glossy->output_order) * coefficientCount(transfer.order);
  const float* row = &table[vertex * transfer.glossy->vertexTable().columns];
  std::vector<double> matrix(transfer.channels * cells, 0.0);
  if (storageOf(transfer) == Storage::kMatrix) matrix.assign(row, row + matrix.size());
  if (storageOf(transfer) == Storage::kVisibility) {
    const TripleProduct product(transfer.glossy->output_order, transfer.order);
    for (const auto& entry : product.entries())
      matrix[entry.i * coefficientCount(transfer.order) + entry.j] += double{entry.value} * row[entry.k];
  }
  if (const auto* clustered = std::get_if<formats::ClusteredOperator>(&transfer.glossy->transfer))
    for (std::size_t member = 0; member <= kComponents; ++member)
      for (std::size_t cell = 0; cell < matrix.size(); ++cell)
        matrix[cell] +=
            (member == 0 ? 1.0 : row[member - 1]) *
            basis[(clustered->clusters[vertex] * (1 + kComponents) + member) * matrix.size() + cell];
  return matrix;
}

class GlossyEvaluatorCases : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    Numbers numbers(5);
    for (int j = 0; j < coefficientCount(GetParam().order); ++j)
      light_.push_back({numbers.next(), numbers.next(), numbers.next()});
  }

  std::vector<Float3> light_;
};

// The kernels of every instruction set of this machine against plain sums in double precision.
TEST_P(GlossyEvaluatorCases, EqualsPlainSums) {
  const ShTransfer transfer = someTransfer(GetParam());
  const std::size_t rows = coefficientCount(transfer.glossy->output_order),
                    columns = coefficientCount(transfer.order);
  const std::size_t count = GetParam().vertices;
  const std::vector<float> table = transfer.glossy->vertexTable().decode();
  const auto* clustered = std::get_if<formats::ClusteredOperator>(&transfer.glossy->transfer);
  const std::vector<float> basis = clustered != nullptr ? clustered->basis.decode() : std::vector<float>();
  std::vector<std::array<double, 3>> transferred(count * rows);
  for (std::size_t v = 0; v < count; ++v) {
    const std::vector<double> matrix = matrixOf(transfer, table, basis, v);
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < rows; ++i) {
        double sum = 0;
        for (std::size_t j = 0; j < columns; ++j)
          sum += matrix[((transfer.channels == 3 ? c : 0) * rows + i) * columns + j] * light_[j][c];
        transferred[v * rows + i][c] = sum;
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
    const std::vector<Float3> found = evaluator.transferredRadiance(light_);
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    ASSERT_EQ(found.size(), transferred.size());
    for (std::size_t e = 0; e < found.size(); ++e)
      for (std::size_t c = 0; c < 3; ++c)
        ASSERT_NEAR(found[e][c], transferred[e][c], tolerance)
            << target << ", entry " << e << ", colour " << c;
  }
  EXPECT_GT(targets, 0);
}

TEST_P(GlossyEvaluatorCases, GivesTheSameBytesWithAnyNumberOfThreads) {
  const GlossyEvaluator evaluator(someTransfer(GetParam()));
  std::vector<Float3> one;
  {
    const tbb::global_control serial(tbb::global_control::max_allowed_parallelism, 1);
    one = evaluator.transferredRadiance(light_);
  }
  EXPECT_EQ(one, evaluator.transferredRadiance(light_));
}

TEST_P(GlossyEvaluatorCases, IsBlackWithoutLight) {
  const GlossyEvaluator evaluator(someTransfer(GetParam()));
  for (const Float3& color : evaluator.transferredRadiance(std::vector<Float3>(light_.size())))
    EXPECT_EQ(color, (Float3{0, 0, 0}));
}

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const auto storage : {Storage::kMatrix, Storage::kVisibility, Storage::kCpca})
    for (const auto precision : {Precision::kFloat32, Precision::kFloat16, Precision::kUint8}) {
      all.push_back({storage, precision, 1, 5, 5, 100});
      all.push_back({storage, precision, 1, 5, 3, 33});
      all.push_back({storage, precision, 1, 2, 4, 16});
      all.push_back({storage, precision, 1, 1, 1, 1});
      all.push_back({storage, precision, 1, 7, 6, 17});
      if (storage != Storage::kVisibility) all.push_back({storage, precision, 3, 5, 4, 50});
    }
  for (const auto storage : {Storage::kMatrix, Storage::kVisibility, Storage::kCpca})
    for (const int order : {3, 4, 8, 9, 10})
      all.push_back({storage, Precision::kFloat32, 1, order, order, 20});
  return all;
}

INSTANTIATE_TEST_SUITE_P(Storages, GlossyEvaluatorCases, testing::ValuesIn(cases()));

TEST(GlossyEvaluator, TellsWhatItReads) {
  ShTransfer transfer = someTransfer({Storage::kMatrix, Precision::kFloat16, 1, 5, 5, 40});
  const GlossyEvaluator matrix(transfer);
  EXPECT_EQ(matrix.tableBytes(), 40u * 625 * 2);
  EXPECT_EQ(matrix.multiplyAdds(), 40 * 3 * 625);
  const GlossyEvaluator cpca(someTransfer({Storage::kCpca, Precision::kFloat32, 1, 5, 5, 40}));
  EXPECT_EQ(cpca.tableBytes(), 40u * (kComponents + 1) * 4 + kClusters * (1 + kComponents) * 625 * 4);
}

TEST(GlossyEvaluator, RefusesWhatDoesNotFit) {
  EXPECT_THROW(GlossyEvaluator{ShTransfer{}}, std::invalid_argument);
  ShTransfer transfer = someTransfer({Storage::kMatrix, Precision::kUint8, 1, 3, 3, 10});
  ShTransfer wrong = transfer;
  wrong.glossy->output_order = 2;
  EXPECT_THROW(GlossyEvaluator{wrong}, std::invalid_argument);
  wrong = someTransfer({Storage::kCpca, Precision::kFloat32, 1, 3, 3, 10});
  clustersOf(wrong).clusters[4] = kClusters;
  EXPECT_THROW(GlossyEvaluator{wrong}, std::invalid_argument);
  const GlossyEvaluator evaluator(transfer);
  std::vector<Float3> transferred(10 * 9 - 1);
  EXPECT_THROW(evaluator.transferredRadiance(std::vector<Float3>(8)), std::invalid_argument);
  EXPECT_THROW(evaluator.transferredRadiance(std::vector<Float3>(9), transferred), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::transport
