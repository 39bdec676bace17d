// Readers of pictures of every kind, by OpenImageIO: what formats/image.h and formats/color_picture.h
// promise, behind picture_module.h; and what they share. Private to formats/.
#pragma once

#include <OpenImageIO/imageio.h>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>

#include "formats/color_picture.h"
#include "formats/image.h"
#include "formats/image_checks.h"

namespace bakelight::formats::oiio {

// `converted`: codes as RGB where the file holds another model (CMYK, YCbCr, a palette).
std::unique_ptr<OIIO::ImageInput> openImage(const std::string& file, bool converted);

// Of the part that `input` stands at: throws for a deep image, a volume, or one that does not fill its frame.
void requireFlat(const OIIO::ImageSpec& spec, const std::string& file);

// The image as it is meant to be seen: the first row on top, the first column to the left. Of the file's
// orientation (as in Exif, 1 to 8; a Radiance picture's resolution line).
Image upright(Image image, const OIIO::ImageInput& input);

Image readImage(const std::filesystem::path& path, NonFinite non_finite);
Image readImage(std::span<const std::byte> bytes, const std::string& name, NonFinite non_finite);
std::map<std::string, std::string> readImageMetadata(const std::filesystem::path& path);
ColorPicture readColorPicture(const std::filesystem::path& path, PictureUse use);

}  // namespace bakelight::formats::oiio
