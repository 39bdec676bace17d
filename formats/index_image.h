// Images of integers: indices must not be rounded, averaged or scaled.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace bakelight::formats {

// Rows from top to bottom, channels interleaved, as Image.
struct IndexImage {
  int width = 0, height = 0;  // px
  std::vector<std::string> channel_names;
  std::vector<std::uint32_t> values;

  IndexImage() = default;
  IndexImage(int width_px, int height_px, std::vector<std::string> channels)
      : width(width_px),
        height(height_px),
        channel_names(std::move(channels)),
        values(static_cast<std::size_t>(width) * height * channel_names.size()) {}
  std::size_t channelCount() const { return channel_names.size(); }
  std::uint32_t* texel(int x, int y) {
    return &values[(static_cast<std::size_t>(y) * width + x) * channelCount()];
  }
  const std::uint32_t* texel(int x, int y) const {
    return &values[(static_cast<std::size_t>(y) * width + x) * channelCount()];
  }
  // Index of a channel by name, or -1.
  int channelIndex(const std::string& name) const;
};

// Scan-line OpenEXR, zip compression, channels of 32-bit unsigned integers. `metadata` become string
// attributes. Atomic. Viewers and readImage() show the numbers as floats, exact below 2^24.
void writeIndexExr(const std::filesystem::path& path, const IndexImage& image,
                   const std::map<std::string, std::string>& metadata = {});

// `channels` of an OpenEXR file, in that order. Throws Error(kBadInput) naming file and channel: no such
// channel, or one that is not of 32-bit unsigned integers; no flat OpenEXR of one part; damaged.
IndexImage readIndexExr(const std::filesystem::path& path, const std::vector<std::string>& channels);

// Names of the channels of an OpenEXR file of one flat part; none for any other file.
std::vector<std::string> exrChannels(const std::filesystem::path& path);

}  // namespace bakelight::formats
