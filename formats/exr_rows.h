// Some channels of an OpenEXR file by blocks of rows, for images that are larger than one wants in memory.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace bakelight::formats {

class ExrRows {
 public:
  // Throws Error(kBadInput) naming file and channel: no flat OpenEXR of one part that fills its frame, or a
  // channel that it does not have.
  ExrRows(const std::filesystem::path& path, std::vector<std::string> channels);
  ~ExrRows();
  ExrRows(const ExrRows&) = delete;
  ExrRows& operator=(const ExrRows&) = delete;

  int width() const;   // px
  int height() const;  // px
  // Rows first … first + count − 1 from the top, channels interleaved in the order asked for: count · width ·
  // channels values as floats. Decompresses on all cores. Throws Error(kBadInput) for a damaged file.
  void read(int first, int count, std::span<float> values);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace bakelight::formats
