// Readers of pictures of every kind, by OpenImageIO: what formats/image.h and formats/color_picture.h
// promise, behind picture_module.h; and what they share. Private to formats/.
#pragma once

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>

#include "formats/color_picture.h"
#include "formats/image.h"
#include "formats/image_checks.h"

namespace bakelight::formats::oiio {

// Values as they stand in the file: colour is not multiplied by alpha.
OIIO::ImageSpec readingHints(bool converted);

// `converted`: codes as RGB where the file holds another model (CMYK, YCbCr, a palette).
std::unique_ptr<OIIO::ImageInput> openImage(const std::string& file, bool converted);

// A picture whose file's bytes are in memory, and have to stay there.
struct ImageInMemory {
  std::unique_ptr<OIIO::Filesystem::IOMemReader> memory;
  std::unique_ptr<OIIO::ImageInput> input;  // reads from `memory`
};

// Its kind is known by the first bytes, that of a Targa picture by the sense of its header. `name` is for
// messages.
ImageInMemory openImage(std::span<const std::byte> bytes, const std::string& name, bool converted);

// Of the part that `input` stands at: throws for a deep image, a volume, or one that does not fill its frame.
void requireFlat(const OIIO::ImageSpec& spec, const std::string& file);

// The image as it is meant to be seen: the first row on top, the first column to the left. Of the file's
// orientation (as in Exif, 1 to 8; a Radiance picture's resolution line).
Image upright(Image image, const OIIO::ImageInput& input);

Image readImage(const std::filesystem::path& path, NonFinite non_finite);
std::map<std::string, std::string> readImageMetadata(const std::filesystem::path& path);
ColorPicture readColorPicture(const std::filesystem::path& path, PictureUse use, PictureTurn turn);
ColorPicture readColorPicture(std::span<const std::byte> bytes, const std::string& name, PictureUse use,
                              PictureTurn turn);

}  // namespace bakelight::formats::oiio
