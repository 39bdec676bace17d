// Readers of pictures of every kind, in a module: OpenImageIO brings some 250 shared libraries, which take a
// third of a second to load. Private to formats/.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>

#include "formats/color_picture.h"
#include "formats/image.h"

namespace bakelight::formats {

// The module's bakelight_picture_readers() returns its own. What formats/image.h and formats/color_picture.h
// promise of the functions of these names.
struct PictureReaders {
  Image (*read_image)(const std::filesystem::path& path, NonFinite non_finite);
  std::map<std::string, std::string> (*read_metadata)(const std::filesystem::path& path);
  ColorPicture (*read_color_picture)(const std::filesystem::path& path, PictureUse use, PictureTurn turn);
  ColorPicture (*read_color_picture_bytes)(std::span<const std::byte> bytes, const std::string& name,
                                           PictureUse use, PictureTurn turn);
};

// Loads them at the first call (module.h), and throws what that does.
const PictureReaders& pictureReaders();

}  // namespace bakelight::formats
