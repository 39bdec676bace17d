#include "transport/translucent_response.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

namespace bakelight::transport {
namespace {

constexpr int kSide = formats::kKernelSide, kReach = kSide / 2;
constexpr std::size_t kValues = std::size_t{3} * formats::kKernelTexels;

std::vector<std::uint32_t> words(const formats::IntegerArray& list) {
  const auto span = formats::wordsOf(list);
  return {span.begin(), span.end()};
}

void require(bool holds) {
  if (!holds) throw std::invalid_argument("a translucent object's tables do not fit each other");
}

}  // namespace

TranslucentResponse::Matrix TranslucentResponse::decoded(const formats::SparseRows& rows) {
  Matrix matrix{words(rows.ends), words(rows.columns), rows.values.decode(), rows.values.columns};
  require(matrix.values.size() == matrix.columns.size() * matrix.value_columns &&
          (matrix.ends.empty() ? matrix.columns.empty() : matrix.ends.back() == matrix.columns.size()));
  return matrix;
}

TranslucentResponse::Matrix TranslucentResponse::Matrix::transposed(std::size_t columns_of_matrix) const {
  Matrix result;
  result.value_columns = value_columns;
  std::vector<std::uint32_t> next(columns_of_matrix + 1, 0);
  for (const std::uint32_t c : columns) ++next[c + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  result.ends.assign(next.begin() + 1, next.end());
  result.columns.resize(columns.size());
  result.values.resize(values.size());
  for (std::size_t r = 0, e = 0; r < ends.size(); ++r)
    for (; e < ends[r]; ++e) {
      const std::uint32_t place = next[columns[e]]++;
      result.columns[place] = static_cast<std::uint32_t>(r);
      std::copy_n(&values[e * value_columns], value_columns, &result.values[place * value_columns]);
    }
  return result;
}

std::vector<Float3> TranslucentResponse::Matrix::times(std::span<const Float3> x) const {
  std::vector<Float3> y(ends.size());
  tbb::parallel_for(std::size_t{0}, ends.size(), [&](std::size_t r) {
    Float3 sum{};
    for (std::size_t e = r == 0 ? 0 : ends[r - 1]; e < ends[r]; ++e) {
      const Float3& from = x[columns[e]];
      const float* value = &values[e * value_columns];
      const std::size_t step = value_columns == 3;
      for (std::size_t c = 0; c < 3; ++c) sum[c] += value[c * step] * from[c];
    }
    y[r] = sum;
  });
  return y;
}

TranslucentResponse::TranslucentResponse(const formats::Translucency& t)
    : resolution_(t.resolution),
      texels_(words(t.texels)),
      receivers_(words(t.receivers)),
      texel_knots_(words(t.texel_knots)),
      areas_(t.areas.decode()),
      sharpen_(decoded(t.sharpen)),
      near_(decoded(t.near)),
      spread_(decoded(t.spread)),
      far_(decoded(t.far)) {
  const std::size_t count = texels_.size();
  const std::vector<float> weights = t.texel_weights.decode(), blend = t.blend.decode();
  require(weights.size() == 2 * count && blend.size() == 9 * count && areas_.size() == count &&
          texel_knots_.size() == 3 * count);
  for (std::size_t i = 0; i < count; ++i)
    weights_.push_back({1 - weights[2 * i] - weights[2 * i + 1], weights[2 * i], weights[2 * i + 1]});

  // What each texel gives, by knot.
  const auto knots = static_cast<std::size_t>(t.knot_count);
  require(sharpen_.ends.size() == knots && near_.ends.size() == knots);
  std::vector<std::uint32_t> next(knots + 1, 0);
  for (std::size_t i = 0; i < count; ++i)
    if (areas_[i] > 0)
      for (std::size_t k = 0; k < 3; ++k) ++next[texel_knots_[3 * i + k] + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  gift_ends_.assign(next.begin() + 1, next.end());
  gifts_.resize(next.back());
  for (std::size_t i = 0; i < count; ++i)
    if (areas_[i] > 0)
      for (std::size_t k = 0; k < 3; ++k) {
        const float* b = &blend[9 * i + 3 * k];
        gifts_[next[texel_knots_[3 * i + k]]++] = {
            static_cast<std::uint32_t>(i), weights_[i][k] * areas_[i], {b[0], b[1], b[2]}};
      }
  sharpen_transposed_ = sharpen_.transposed(knots);
  spread_transposed_ = spread_.transposed(static_cast<std::size_t>(t.far_count));

  kernels_ = t.kernels.decode();
  if (t.components > 0) {
    const auto components = static_cast<std::size_t>(t.components);
    require(kernels_.size() == receivers_.size() * components && t.basis.size() == components * kValues);
    std::vector<float> expanded(receivers_.size() * kValues, 0);
    tbb::parallel_for(std::size_t{0}, receivers_.size(), [&](std::size_t r) {
      for (std::size_t c = 0; c < components; ++c)
        for (std::size_t v = 0; v < kValues; ++v)
          expanded[r * kValues + v] += kernels_[r * components + c] * t.basis[c * kValues + v];
    });
    kernels_ = std::move(expanded);
  }
  require(kernels_.size() == receivers_.size() * kValues);
}

std::vector<Float3> TranslucentResponse::interpolated(std::span<const Float3> at_knots) const {
  std::vector<Float3> result(texels_.size());
  tbb::parallel_for(std::size_t{0}, texels_.size(), [&](std::size_t i) {
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t c = 0; c < 3; ++c)
        result[i][c] += weights_[i][k] * at_knots[texel_knots_[3 * i + k]][c];
  });
  return result;
}

std::vector<Float3> TranslucentResponse::atKnots(std::span<const Float3> entering) const {
  if (entering.size() != texels_.size()) throw std::invalid_argument("light is not one value a texel");
  std::vector<Float3> power(gift_ends_.size()), given(gift_ends_.size());
  tbb::parallel_for(std::size_t{0}, gift_ends_.size(), [&](std::size_t k) {
    Float3 e{}, d{};
    for (std::size_t g = k == 0 ? 0 : gift_ends_[k - 1]; g < gift_ends_[k]; ++g) {
      const Gift& gift = gifts_[g];
      for (std::size_t c = 0; c < 3; ++c) {
        e[c] += gift.power * entering[gift.texel][c];
        d[c] += gift.blend[c] * entering[gift.texel][c];
      }
    }
    power[k] = e, given[k] = d;
  });
  const auto add = [](std::vector<Float3>& to, const std::vector<Float3>& from) {
    for (std::size_t i = 0; i < to.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) to[i][c] += from[i][c];
  };
  const std::vector<Float3> sharpened = sharpen_transposed_.times(power);
  std::vector<Float3> response = near_.times(sharpened);
  if (!far_.ends.empty()) add(response, spread_.times(far_.times(spread_transposed_.times(sharpened))));
  response = sharpen_.times(response);
  add(response, given);
  return response;
}

std::vector<Float3> TranslucentResponse::respond(std::span<const Float3> entering, Branches branches) const {
  const std::vector<Float3> at_knots =
      branches == Branches::kLocal ? std::vector<Float3>(gift_ends_.size()) : atKnots(entering);
  std::vector<Float3> picture;  // with a margin, so that no window leaves it
  const std::size_t width = static_cast<std::size_t>(resolution_) + 2 * kReach;
  if (branches != Branches::kGlobal) {
    if (entering.size() != texels_.size()) throw std::invalid_argument("light is not one value a texel");
    picture.resize(width * width);
    for (std::size_t i = 0; i < texels_.size(); ++i) {
      const std::size_t x = texels_[i] % static_cast<std::size_t>(resolution_),
                        y = texels_[i] / static_cast<std::size_t>(resolution_);
      picture[(y + kReach) * width + x + kReach] = entering[i];
    }
  }
  std::vector<Float3> result(receivers_.size());
  tbb::parallel_for(std::size_t{0}, receivers_.size(), [&](std::size_t r) {
    const std::uint32_t texel = receivers_[r];
    Float3 sum{};
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t c = 0; c < 3; ++c)
        sum[c] += weights_[texel][k] * at_knots[texel_knots_[3 * texel + k]][c];
    if (branches != Branches::kGlobal) {
      const std::size_t x = texels_[texel] % static_cast<std::size_t>(resolution_),
                        y = texels_[texel] / static_cast<std::size_t>(resolution_);
      const float* kernel = &kernels_[r * kValues];
      for (std::size_t row = 0; row < kSide; ++row) {
        const Float3* light = &picture[(y + row) * width + x];
        for (std::size_t column = 0; column < kSide; ++column, kernel += 3)
          for (std::size_t c = 0; c < 3; ++c) sum[c] += kernel[c] * light[column][c];
      }
    }
    result[r] = sum;
  });
  return result;
}

}  // namespace bakelight::transport
