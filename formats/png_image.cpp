#include "formats/png_image.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "formats/image_checks.h"

namespace bakelight::formats {

Bytes encodedPng(const Image& image, const std::string& file) {
  checkShape(image);
  if (image.channelCount() > 4) throw std::logic_error("a PNG has 1 to 4 channels");
  requireFinite(image, file);
  std::vector<std::uint8_t> codes(image.values.size());
  std::transform(image.values.begin(), image.values.end(), codes.begin(), [](float value) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0F, 1.0F) * 255.0F));
  });
  constexpr std::array<png_uint_32, 4> kFormats = {PNG_FORMAT_GRAY, PNG_FORMAT_GA, PNG_FORMAT_RGB,
                                                   PNG_FORMAT_RGBA};
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = kFormats[image.channelCount() - 1];
  // An upper bound, then the file itself.
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  Bytes bytes(size);
  if (png_image_write_to_memory(&header, bytes.data(), &size, 0, codes.data(), 0, nullptr) == 0)
    throw cannotWrite(file, static_cast<const char*>(header.message));
  bytes.resize(size);
  return bytes;
}

}  // namespace bakelight::formats
