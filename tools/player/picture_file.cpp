#include "tools/player/picture_file.h"

#include <string>

#include "formats/error.h"
#include "formats/file.h"

namespace bakelight::player {

PictureEncoding encodingFor(const std::filesystem::path& picture_path) {
  const std::string ending = formats::lowerEnding(picture_path);
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
