#include "formats/patch_levels.h"

#include <algorithm>

#include "formats/factored_patch.h"

namespace bakelight::formats {
namespace {

// Shares of the texels of a row of `from` that each of `to` texels covers.
struct Cover {
  int first = 0;
  std::vector<double> shares;  // sum 1
};
std::vector<Cover> covers(int from, int to) {
  std::vector<Cover> result(static_cast<std::size_t>(to));
  for (int i = 0; i < to; ++i) {
    const double begin = static_cast<double>(i) * from / to, end = static_cast<double>(i + 1) * from / to;
    Cover& cover = result[static_cast<std::size_t>(i)];
    cover.first = static_cast<int>(begin);
    for (int x = cover.first; x < end && x < from; ++x)
      cover.shares.push_back((std::min(end, x + 1.0) - std::max<double>(begin, x)) / (end - begin));
  }
  return result;
}

}  // namespace

std::vector<float> withLevels(std::span<const float> finest, int width, int height, std::size_t a_texel) {
  const std::vector<RttLevel> levels = rttLevels(width, height);
  std::vector<float> values(rttTexelCount(levels) * a_texel, 0.0F);
  std::copy(finest.begin(), finest.end(), values.begin());
  for (std::size_t l = 1; l < levels.size(); ++l) {
    const RttLevel& level = levels[l];
    const std::vector<Cover> across = covers(width, level.width), down = covers(height, level.height);
    for (int y = 0; y < level.height; ++y)
      for (int x = 0; x < level.width; ++x) {
        const std::size_t texel = level.first_texel + static_cast<std::size_t>(y) * level.width + x;
        float* mean = &values[texel * a_texel];
        const Cover &rows = down[static_cast<std::size_t>(y)], &columns = across[static_cast<std::size_t>(x)];
        for (std::size_t j = 0; j < rows.shares.size(); ++j)
          for (std::size_t i = 0; i < columns.shares.size(); ++i) {
            const auto share = static_cast<float>(rows.shares[j] * columns.shares[i]);
            const float* covered =
                &finest[((static_cast<std::size_t>(rows.first) + j) * width + columns.first + i) * a_texel];
            for (std::size_t k = 0; k < a_texel; ++k) mean[k] += share * covered[k];
          }
      }
  }
  return values;
}

}  // namespace bakelight::formats
