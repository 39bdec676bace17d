#include "tools/player/picture_file.h"

#include <algorithm>
#include <cctype>
#include <string>

#include "formats/error.h"

namespace bakelight::player {

PictureEncoding encodingFor(const std::filesystem::path& picture_path) {
  std::string ending = picture_path.extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (ending == ".png") return PictureEncoding::kDisplay;
  if (ending == ".exr") return PictureEncoding::kLinear;
  throw Error(ExitStatus::kUsage, {picture_path.string(), "", ""},
              "is no kind of picture that the player writes", "a name that ends in .png or .exr");
}

void writePicture(const std::filesystem::path& path, const formats::Image& image, PictureEncoding encoding) {
  if (encoding == PictureEncoding::kDisplay)
    formats::writePng(path, image);
  else
    formats::writeExr(path, image, formats::ExrPrecision::kFloat);
}

}  // namespace bakelight::player
