#include "formats/image.h"

#include <algorithm>
#include <new>

#include "formats/exr_image.h"
#include "formats/file.h"
#include "formats/gltf_uri.h"
#include "formats/image_checks.h"
#include "formats/picture_module.h"
#include "formats/png_image.h"

namespace bakelight::formats {

int Image::channelIndex(const std::string& name) const {
  const auto found = std::find(channel_names.begin(), channel_names.end(), name);
  return found == channel_names.end() ? -1 : static_cast<int>(found - channel_names.begin());
}

Image readImage(const std::filesystem::path& path, NonFinite non_finite) {
  try {
    std::optional<Image> plain = readPlainExr(path);
    if (!plain) return pictureReaders().read_image(path, non_finite);
    if (non_finite == NonFinite::kReject) requireFinite(*plain, path.string());
    return std::move(*plain);
  } catch (const std::bad_alloc&) {
    throw tooLargeImage(path.string());
  }
}

std::map<std::string, std::string> readImageMetadata(const std::filesystem::path& path) {
  auto plain = plainExrMetadata(path);
  return plain ? std::move(*plain) : pictureReaders().read_metadata(path);
}

void writeExr(const std::filesystem::path& path, const Image& image, ExrPrecision precision,
              const std::map<std::string, std::string>& metadata) {
  checkShape(image);
  requireFinite(image, path.string());
  if (precision == ExrPrecision::kHalf) requireHalves(image, path.string());
  writeFileAtomically(path, encodedExr(image, precision, metadata));
}

void writePng(const std::filesystem::path& path, const Image& image) {
  writeFileAtomically(path, encodedPng(image, path.string()));
}

std::string pngDataUri(const Image& image) {
  return dataUri("image/png", encodedPng(image, "picture.png"));
}

}  // namespace bakelight::formats
