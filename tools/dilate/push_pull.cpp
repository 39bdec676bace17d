#include "tools/dilate/push_pull.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace bakelight::dilate {
namespace {

struct Level {
  formats::Image image;
  std::vector<std::uint8_t> covered;

  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * image.width + x; }
};

Level coarser(const Level& fine) {
  const int width = (fine.image.width + 1) / 2, height = (fine.image.height + 1) / 2;
  Level result{formats::Image(width, height, fine.image.channel_names), {}};
  result.covered.assign(static_cast<std::size_t>(width) * height, 0);
  const std::size_t channels = fine.image.channelCount();
  tbb::parallel_for(0, height, [&](int y) {
    std::vector<double> sum(channels);
    for (int x = 0; x < width; ++x) {
      std::fill(sum.begin(), sum.end(), 0.0);
      int count = 0;
      for (int child_y = 2 * y; child_y < std::min(2 * y + 2, fine.image.height); ++child_y)
        for (int child_x = 2 * x; child_x < std::min(2 * x + 2, fine.image.width); ++child_x) {
          if (fine.covered[fine.index(child_x, child_y)] == 0) continue;
          ++count;
          for (std::size_t c = 0; c < channels; ++c) sum[c] += fine.image.texel(child_x, child_y)[c];
        }
      if (count == 0) continue;
      result.covered[result.index(x, y)] = 1;
      for (std::size_t c = 0; c < channels; ++c)
        result.image.texel(x, y)[c] = static_cast<float>(sum[c] / count);
    }
  });
  return result;
}

// The two texels of a coarser row or column about a finer one's centre: ¾ of its own parent, ¼ of the next.
struct Pair {
  int own, next;
};
Pair parentsOf(int child, int parent_count) {
  const int own = child / 2;
  return {own, std::clamp(child % 2 == 0 ? own - 1 : own + 1, 0, parent_count - 1)};
}

void fillFrom(const formats::Image& coarse, Level& fine) {
  tbb::parallel_for(0, fine.image.height, [&](int y) {
    const Pair rows = parentsOf(y, coarse.height);
    for (int x = 0; x < fine.image.width; ++x) {
      if (fine.covered[fine.index(x, y)] != 0) continue;
      const Pair columns = parentsOf(x, coarse.width);
      for (std::size_t c = 0; c < fine.image.channelCount(); ++c) {
        const double own =
            0.75 * coarse.texel(columns.own, rows.own)[c] + 0.25 * coarse.texel(columns.next, rows.own)[c];
        const double next =
            0.75 * coarse.texel(columns.own, rows.next)[c] + 0.25 * coarse.texel(columns.next, rows.next)[c];
        fine.image.texel(x, y)[c] = static_cast<float>(0.75 * own + 0.25 * next);
      }
    }
  });
}

}  // namespace

formats::Image pushPull(const formats::Image& image, std::span<const std::uint8_t> covered) {
  std::vector<Level> levels = {{image, {covered.begin(), covered.end()}}};
  while (levels.back().image.width > 1 || levels.back().image.height > 1)
    levels.push_back(coarser(levels.back()));
  for (std::size_t level = levels.size() - 1; level > 0; --level)
    fillFrom(levels[level].image, levels[level - 1]);
  return std::move(levels.front().image);
}

}  // namespace bakelight::dilate
