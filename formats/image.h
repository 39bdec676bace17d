// Images with named channels, through OpenImageIO: OpenEXR and Radiance HDR in, OpenEXR and PNG out.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace bakelight::formats {

// Rows from top to bottom, channels interleaved: value(x, y, c) at ((y * width + x) * channels + c).
struct Image {
  int width = 0, height = 0;  // px
  std::vector<std::string> channel_names;
  std::vector<float> values;

  Image() = default;
  Image(int width_px, int height_px, std::vector<std::string> channels)
      : width(width_px),
        height(height_px),
        channel_names(std::move(channels)),
        values(static_cast<std::size_t>(width) * height * channel_names.size()) {}
  std::size_t channelCount() const { return channel_names.size(); }
  float* texel(int x, int y) { return &values[(static_cast<std::size_t>(y) * width + x) * channelCount()]; }
  const float* texel(int x, int y) const {
    return &values[(static_cast<std::size_t>(y) * width + x) * channelCount()];
  }
  // Index of a channel by name, or -1.
  int channelIndex(const std::string& name) const;
};

enum class ExrPrecision { kHalf, kFloat };

// What reading does about values that are NaN or infinite.
enum class NonFinite { kReject, kKeep };

// Reads any image OpenImageIO knows (of several parts the first), as floats, channels in file order, turned
// upright where the file says how it lies; 8- and 16-bit images are scaled to [0, 1] and otherwise left as
// they are (no colour conversion: formats/color_picture.h reads light and albedo). Throws Error(kBadInput)
// naming file, and texel and channel where a value is rejected.
Image readImage(const std::filesystem::path& path, NonFinite non_finite = NonFinite::kReject);

// The string attributes of an image, those of writeExr's `metadata` among them. Throws as readImage does;
// pixels are not looked at. OpenEXR keeps no empty text.
std::map<std::string, std::string> readImageMetadata(const std::filesystem::path& path);

// Scan-line OpenEXR, zip compression, one named channel each. Half holds integers exactly to 2048 only and
// overflows at 65504: a value that does not fit throws Error(kBadInput) naming texel and channel. `metadata`
// become string attributes. No date, host or program name goes in. Atomic.
void writeExr(const std::filesystem::path& path, const Image& image,
              ExrPrecision precision = ExrPrecision::kHalf,
              const std::map<std::string, std::string>& metadata = {});

// 8-bit PNG; values are display-encoded (sRGB already applied), clamped to [0, 1]. 1 to 4 channels. Atomic.
void writePng(const std::filesystem::path& path, const Image& image);

// The same picture as a URI that carries it, for the pages of reports: "data:image/png;base64,…".
std::string pngDataUri(const Image& image);

}  // namespace bakelight::formats
