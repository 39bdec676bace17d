#include "tools/inspect/image_figures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "transport/lights.h"

namespace bakelight::inspect {

using formats::Image;

std::vector<Moments> measureChannels(const Image& image) {
  std::vector<Moments> channels(image.channelCount());
  for (std::size_t i = 0; i < image.values.size(); ++i) channels[i % channels.size()].add(image.values[i]);
  return channels;
}

std::optional<std::array<std::size_t, 3>> colorChannels(const Image& image) {
  if (image.channelCount() == 1) return {{0, 0, 0}};
  const std::array<std::string, 3> names = {"R", "G", "B"};
  std::array<std::size_t, 3> found{};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto entry = std::find_if(
        image.channel_names.begin(), image.channel_names.end(),
        [&](const std::string& name) { return name == names[c] || name.ends_with("." + names[c]); });
    if (entry == image.channel_names.end()) return std::nullopt;
    found[c] = static_cast<std::size_t>(entry - image.channel_names.begin());
  }
  return found;
}

double luminance(double red, double green, double blue) {
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
}

std::optional<ProbeFigures> measureProbe(const Image& image, const std::string& file) {
  const auto channels = colorChannels(image);
  const bool finite =
      std::all_of(image.values.begin(), image.values.end(), [](float v) { return std::isfinite(v); });
  if (!channels || !finite || image.width != 2 * image.height) return std::nullopt;

  ProbeFigures probe;
  double brightest = 0;
  std::vector<double> luminances;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const float* texel = image.texel(x, y);
      const std::array<double, 3> radiance = {texel[(*channels)[0]], texel[(*channels)[1]],
                                              texel[(*channels)[2]]};
      const double value = luminance(radiance[0], radiance[1], radiance[2]);
      luminances.push_back(value);
      if (value <= brightest) continue;
      brightest = value;
      probe.brightest_radiance = radiance;
      probe.brightest_direction =
          transport::directionOfLatLong((x + 0.5) / image.width, (y + 0.5) / image.height);
    }
  }
  if (brightest <= 0) return std::nullopt;
  // The darkest texels of a photograph hold noise.
  const auto dark = luminances.begin() + static_cast<std::ptrdiff_t>(luminances.size() / 100);
  std::nth_element(luminances.begin(), dark, luminances.end());
  if (*dark > 0) probe.dynamic_range_stops = std::log2(brightest / *dark);

  // ∫L dω = √(4π) L_00, and the mean is that over 4π.
  const transport::ShLight ambient = transport::projectLatLong(image, 1, file);
  for (std::size_t c = 0; c < 3; ++c)
    probe.mean_radiance[c] = ambient[0][c] / std::sqrt(4 * std::numbers::pi);
  return probe;
}

}  // namespace bakelight::inspect
