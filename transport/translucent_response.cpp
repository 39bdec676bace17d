#include "transport/translucent_response.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <Eigen/Core>
#include <stdexcept>

namespace bakelight::transport {
namespace {

constexpr int kSide = formats::kKernelSide, kReach = kSide / 2;
constexpr std::size_t kValues = std::size_t{3} * formats::kKernelTexels;

std::vector<std::uint32_t> words(const formats::IntegerArray& list) {
  const auto span = formats::wordsOf(list);
  return {span.begin(), span.end()};
}

}  // namespace

TranslucentResponse::Matrix TranslucentResponse::decoded(const formats::SparseRows& rows) {
  Matrix matrix{words(rows.ends), words(rows.columns), rows.values.decode(), rows.values.columns};
  matrix.values.push_back(0);  // a color is read as four numbers
  return matrix;
}

// An entry is one product of four numbers, of which the last means nothing; four sums, so that none waits for the other.
std::vector<Float3> TranslucentResponse::Matrix::times(std::span<const Float3> x) const {
  using Four = Eigen::Array4f;
  std::vector<Four> padded;
  padded.reserve(x.size());
  for (const Float3& value : x) padded.emplace_back(value[0], value[1], value[2], 0);
  std::vector<Float3> y(ends.size());
  const auto product = [&](std::size_t e) -> Four {
    const Four& from = padded[columns[e]];
    if (value_columns == 1) return values[e] * from;
    return Eigen::Map<const Four>(&values[3 * e]) * from;
  };
  tbb::parallel_for(std::size_t{0}, ends.size(), [&](std::size_t r) {
    std::array<Four, 4> sums;
    sums.fill(Four::Zero());
    std::size_t e = r == 0 ? 0 : ends[r - 1];
    for (; e + 4 <= ends[r]; e += 4)
      for (std::size_t k = 0; k < 4; ++k) sums[k] += product(e + k);
    for (; e < ends[r]; ++e) sums[0] += product(e);
    sums[0] += sums[1] + (sums[2] + sums[3]);
    y[r] = {sums[0][0], sums[0][1], sums[0][2]};
  });
  return y;
}

TranslucentResponse::TranslucentResponse(const formats::Translucency& t) : resolution_(t.resolution) {
  requireFit(t);
  texels_ = words(t.texels);
  receivers_ = words(t.receivers);
  texel_knots_ = words(t.texel_knots);
  weights_ = knotWeights(t);
  kernels_ = expandedKernels(t);
  gifts_ = giftsOf(t);
  sharpen_ = decoded(t.sharpen);
  sharpen_transposed_ = decoded(transposed(t.sharpen, static_cast<std::size_t>(t.knot_count)));
  near_ = decoded(t.near);
  if (t.far_count == 0) return;
  spread_ = decoded(t.spread);
  spread_transposed_ = decoded(transposed(t.spread, static_cast<std::size_t>(t.far_count)));
  far_ = decoded(t.far);
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
  std::vector<Float3> power(gifts_.ends.size()), given(gifts_.ends.size());
  tbb::parallel_for(std::size_t{0}, gifts_.ends.size(), [&](std::size_t k) {
    Float3 e{}, d{};
    for (std::size_t g = k == 0 ? 0 : gifts_.ends[k - 1]; g < gifts_.ends[k]; ++g) {
      const Gift& gift = gifts_.gifts[g];
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
      branches == Branches::kLocal ? std::vector<Float3>(gifts_.ends.size()) : atKnots(entering);
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
