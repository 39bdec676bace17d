#include "transport/btf_factorization.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <Eigen/Dense>
#include <functional>
#include <numbers>
#include <string>

#include "formats/error.h"
#include "transport/random.h"

namespace bakelight::transport {
namespace {

using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
constexpr std::size_t kChannels = 3, kBlock = 256;  // texels
constexpr int kOversampling = 10, kPowerIterations = 2;

// Standard normal numbers that depend on their place alone.
Rows randomRows(std::size_t rows, Eigen::Index columns) {
  Rows values(static_cast<Eigen::Index>(rows), columns);
  constexpr double kUnit = 1.0 / 9007199254740992.0;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const std::uint64_t bits = scrambled(static_cast<std::uint64_t>(i));
    const double u = (static_cast<double>(bits >> 11) + 0.5) * kUnit;
    const double angle = static_cast<double>(scrambled(bits) >> 11) * kUnit;
    values.data()[i] =
        static_cast<float>(std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * angle));
  }
  return values;
}

// An orthonormal basis of what the columns span.
Rows orthonormal(const Rows& columns) {
  const Eigen::HouseholderQR<Eigen::MatrixXf> qr(columns);
  return qr.householderQ() * Eigen::MatrixXf::Identity(columns.rows(), columns.cols());
}

class Matrix {
 public:
  Matrix(const formats::Btf& btf, formats::BtfColorModel model)
      : btf_(btf), model_(model), lights_(btf.Btf::lightsOf(0)) {
    for (std::size_t v = 0; v < viewCount(); ++v)
      if (btf.lightsOf(static_cast<int>(v)).size() != lights_.size())
        throw badInput({btf.info().file, "view " + std::to_string(v), ""},
                       "pictures under some lights are missing", "all of them: a .btf has no gaps");
  }

  std::size_t viewCount() const { return btf_.info().views.size(); }
  std::size_t directionCount() const { return viewCount() * lights_.size(); }
  std::size_t texelCount() const { return btf_.texelCount(); }

  // Of each channel: this · right, by texel; and the sum of squares and what logarithms took for 0.
  std::vector<Rows> timesTexels(const std::vector<Rows>& right, std::array<double, kChannels>& squares,
                                std::size_t& negative) const {
    const Eigen::Index columns = right[0].cols();
    std::vector<Rows> result(kChannels, Rows::Zero(static_cast<Eigen::Index>(directionCount()), columns));
    struct Partial {
      std::array<Rows, kChannels> product;
      std::array<double, kChannels> squares = {};
      std::size_t negative = 0;
    };
    squares = {}, negative = 0;
    for (std::size_t v = 0; v < viewCount(); ++v) {
      std::vector<Partial> partials(blockCount());
      forBlocks(v, [&](std::size_t block, std::size_t first, std::size_t c, const Rows& values,
                       std::size_t block_negative) {
        partials[block].product[c] =
            values * right[c].middleRows(static_cast<Eigen::Index>(first), values.cols());
        partials[block].squares[c] = values.cast<double>().squaredNorm();
        partials[block].negative = block_negative;
      });
      for (const Partial& partial : partials) {
        negative += partial.negative;
        for (std::size_t c = 0; c < kChannels; ++c) {
          result[c].middleRows(static_cast<Eigen::Index>(v * lights_.size()),
                               static_cast<Eigen::Index>(lights_.size())) += partial.product[c];
          squares[c] += partial.squares[c];
        }
      }
    }
    return result;
  }

  // Of each channel: thisᵀ · left, by direction.
  std::vector<Rows> timesDirections(const std::vector<Rows>& left) const {
    std::vector<Rows> result(kChannels, Rows::Zero(static_cast<Eigen::Index>(texelCount()), left[0].cols()));
    for (std::size_t v = 0; v < viewCount(); ++v)
      forBlocks(v, [&](std::size_t, std::size_t first, std::size_t c, const Rows& values, std::size_t) {
        result[c].middleRows(static_cast<Eigen::Index>(first), values.cols()).noalias() +=
            values.transpose() *
            left[c].middleRows(static_cast<Eigen::Index>(v * lights_.size()), values.rows());
      });
    return result;
  }

 private:
  using Visit = std::function<void(std::size_t block, std::size_t first, std::size_t channel,
                                   const Rows& values, std::size_t negative)>;
  std::size_t blockCount() const { return (texelCount() + kBlock - 1) / kBlock; }

  void forBlocks(std::size_t v, const Visit& visit) const {
    const auto view = btf_.view(static_cast<int>(v));
    tbb::parallel_for(std::size_t{0}, blockCount(), [&](std::size_t block) {
      const std::size_t first = block * kBlock, count = std::min(kBlock, texelCount() - first);
      std::vector<float> planes(kChannels * lights_.size() * count);
      view->decode(lights_, {first, count}, planes);
      const std::size_t negative = formats::decorrelate(model_, planes, lights_.size() * count);
      for (std::size_t c = 0; c < kChannels; ++c)
        visit(block, first, c,
              Eigen::Map<const Rows>(planes.data() + c * lights_.size() * count,
                                     static_cast<Eigen::Index>(lights_.size()),
                                     static_cast<Eigen::Index>(count)),
              negative);
    });
  }

  const formats::Btf& btf_;
  formats::BtfColorModel model_;
  std::vector<int> lights_;
};

std::vector<float> listOf(const Rows& values) {
  return {values.data(), values.data() + values.size()};
}

// The matrix is basis · projectionᵀ, where the basis is orthonormal.
formats::BtfFactors truncated(const Rows& basis, const Rows& projection, int rank, double& squares_kept) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(projection.cast<double>());
  const Eigen::Index columns = projection.cols();
  const Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(projection.rows(), columns);
  const Eigen::MatrixXd r = qr.matrixQR().topRows(columns).triangularView<Eigen::Upper>();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(r, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::VectorXd& values = svd.singularValues();
  constexpr double kRounding = 1e-6;
  Eigen::Index kept = 0;
  while (kept < std::min<Eigen::Index>(rank, values.size()) && values[kept] > kRounding * values[0]) ++kept;
  const Eigen::MatrixXd directions = basis.cast<double>() * svd.matrixV().leftCols(kept);
  const Eigen::MatrixXd texels = q * svd.matrixU().leftCols(kept) * values.head(kept).asDiagonal();
  squares_kept = values.head(kept).squaredNorm();
  const Eigen::VectorXf singular = values.head(kept).cast<float>();
  return {static_cast<std::size_t>(kept),
          {singular.data(), singular.data() + kept},
          listOf(directions.cast<float>()),
          listOf(texels.cast<float>())};
}

}  // namespace

BtfFactorization factorize(const formats::Btf& btf, formats::BtfColorModel model, int rank) {
  const Matrix matrix(btf, model);
  const auto columns = static_cast<Eigen::Index>(std::min(
      {static_cast<std::size_t>(rank + kOversampling), matrix.directionCount(), matrix.texelCount()}));
  BtfFactorization result;
  std::array<double, kChannels> squares = {};
  std::vector<Rows> right(kChannels, randomRows(matrix.texelCount(), columns));
  std::vector<Rows> left;
  for (int iteration = 0;; ++iteration) {
    left = matrix.timesTexels(right, squares, result.negative_values);
    for (Rows& basis : left) basis = orthonormal(basis);
    right = matrix.timesDirections(left);
    if (iteration == kPowerIterations) break;
    for (Rows& basis : right) basis = orthonormal(basis);
  }
  for (std::size_t c = 0; c < kChannels; ++c) {
    double kept = 0;
    result.channels.push_back(truncated(left[c], right[c], rank, kept));
    result.relative_errors.push_back(squares[c] > 0 ? std::sqrt(std::max(squares[c] - kept, 0.0) / squares[c])
                                                    : 0);
  }
  return result;
}

double relativeError(const formats::Btf& btf, const formats::Btf& expected) {
  const std::size_t texels = expected.texelCount(), blocks = (texels + kBlock - 1) / kBlock;
  double differences = 0, squares = 0;
  for (std::size_t v = 0; v < expected.info().views.size(); ++v) {
    const auto view = btf.view(static_cast<int>(v)), expected_view = expected.view(static_cast<int>(v));
    const std::vector<int> lights = expected.lightsOf(static_cast<int>(v));
    std::vector<std::array<double, 2>> partial(blocks);
    tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
      const std::size_t first = block * kBlock, count = std::min(kBlock, texels - first);
      std::vector<float> a(3 * lights.size() * count), b(a.size());
      view->decode(lights, {first, count}, a);
      expected_view->decode(lights, {first, count}, b);
      for (std::size_t i = 0; i < a.size(); ++i) {
        const double difference = static_cast<double>(a[i]) - b[i];
        partial[block][0] += difference * difference;
        partial[block][1] += static_cast<double>(b[i]) * b[i];
      }
    });
    for (const auto& [difference, square] : partial) differences += difference, squares += square;
  }
  return squares > 0 ? std::sqrt(differences / squares) : std::sqrt(differences);
}

}  // namespace bakelight::transport
