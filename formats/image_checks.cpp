#include "formats/image_checks.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

namespace bakelight::formats {
namespace {

constexpr float kLargestHalf = 65504.0F;

std::string elementName(const Image& image, std::size_t value_index) {
  const std::size_t texel = value_index / image.channelCount();
  const auto width = static_cast<std::size_t>(image.width);
  return "texel (" + std::to_string(texel % width) + ", " + std::to_string(texel / width) + "), channel " +
         image.channel_names[value_index % image.channelCount()];
}

}  // namespace

Error unreadableImage(const std::string& file, const std::string& reason) {
  return badInput({file, "", ""}, "the image cannot be read (" + reason + ")", "a whole image file",
                  "copy or make it again");
}

Error tooLargeImage(const std::string& file) {
  return badInput({file, "", ""}, "the image does not fit into memory", "a smaller image");
}

void requireFinite(const Image& image, const std::string& file) {
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    if (std::isfinite(image.values[i])) continue;
    throw badInput({file, elementName(image, i), ""},
                   std::isnan(image.values[i]) ? "it is NaN" : "it is infinite", "finite values",
                   "repair the image, for example with oiiotool --fixnan box3");
  }
}

void requireHalves(const Image& image, const std::string& file) {
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    if (std::abs(image.values[i]) <= kLargestHalf) continue;
    throw badInput({file, elementName(image, i), ""},
                   "the value " + std::to_string(image.values[i]) + " does not fit half precision",
                   "at most 65504 in magnitude", "scale the image down, or write it with 32-bit floats");
  }
}

void checkShape(const Image& image) {
  const std::set<std::string> names(image.channel_names.begin(), image.channel_names.end());
  if (image.width < 1 || image.height < 1 || names.empty() || names.size() != image.channelCount()) {
    throw std::logic_error("an image has at least one texel, and channels of different names");
  }
  if (image.values.size() != static_cast<std::size_t>(image.width) * image.height * image.channelCount()) {
    throw std::logic_error("an image has one value for each texel and channel");
  }
}

std::string noteIfBlack(const Image& image, const std::string& file) {
  const bool is_black =
      std::all_of(image.values.begin(), image.values.end(), [](float value) { return value == 0; });
  return is_black ? file + " is black everywhere: it gives no light" : "";
}

}  // namespace bakelight::formats
