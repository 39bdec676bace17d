// What the readers of images share. Private to formats/.
#pragma once

#include <OpenImageIO/imageio.h>
#include <memory>
#include <string>

#include "formats/error.h"
#include "formats/image.h"

namespace bakelight::formats {

// `converted`: codes as RGB where the file holds another model (CMYK, YCbCr, a palette).
std::unique_ptr<OIIO::ImageInput> openImage(const std::string& file, bool converted);

// Of the part that `input` stands at: throws for a deep image, a volume, or one that does not fill its frame.
void requireFlat(const OIIO::ImageSpec& spec, const std::string& file);

Error unreadableImage(const std::string& file, const std::string& reason);

// The image as it is meant to be seen: the first row on top, the first column to the left. Of the file's
// orientation (as in Exif, 1 to 8; a Radiance picture's resolution line).
Image upright(Image image, const OIIO::ImageInput& input);

// Throws for a value that is NaN or infinite, naming its texel and channel.
void requireFinite(const Image& image, const std::string& file);

}  // namespace bakelight::formats
