#include "tools/dilate/dilate.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <stdexcept>

#include "formats/error.h"
#include "tools/dilate/push_pull.h"
#include "transport/nearest_texel.h"

namespace bakelight::dilate {

std::vector<std::uint8_t> coveredTexels(const formats::Image& maps, const std::string& file) {
  const int channel = maps.channelIndex("coverage");
  if (channel < 0)
    throw badInput({file, "channel coverage", ""}, "there is no such channel", "geometry maps",
                   "give the maps that atlas wrote");
  std::vector<std::uint8_t> covered(static_cast<std::size_t>(maps.width) * maps.height);
  for (std::size_t i = 0; i < covered.size(); ++i)
    covered[i] = maps.values[i * maps.channelCount() + channel] != 0;
  if (std::find(covered.begin(), covered.end(), 1) == covered.end())
    throw badInput({file, "channel coverage", ""}, "no texel is covered",
                   "one at least to fill the others from");
  return covered;
}

Dilation dilated(formats::Image image, std::span<const std::uint8_t> covered, const DilateOptions& options) {
  if (covered.size() != static_cast<std::size_t>(image.width) * image.height)
    throw std::logic_error("coverage and image differ in size");
  const int width = image.width;
  const std::size_t channels = image.channelCount();
  const std::vector<std::uint32_t> nearest = transport::nearestTexels(covered, width, image.height);
  const bool averages = options.method == Method::kPushPull;
  const formats::Image filled = averages ? pushPull(image, covered) : formats::Image();

  std::vector<std::int64_t> counts(image.height, 0);
  tbb::parallel_for(0, image.height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const std::size_t texel = static_cast<std::size_t>(y) * width + x;
      const std::int64_t source_x = nearest[texel] % static_cast<std::uint32_t>(width),
                         source_y = nearest[texel] / static_cast<std::uint32_t>(width);
      const std::int64_t dx = source_x - x, dy = source_y - y, reach = options.reach;
      if (covered[texel] != 0 || (reach > 0 && dx * dx + dy * dy > reach * reach)) continue;
      // Covered texels are read, and others written.
      const float* source = averages ? filled.texel(x, y) : &image.values[nearest[texel] * channels];
      std::copy_n(source, channels, image.texel(x, y));
      ++counts[y];
    }
  });
  Dilation result{std::move(image), 0};
  for (const std::int64_t count : counts) result.filled += count;
  return result;
}

}  // namespace bakelight::dilate
