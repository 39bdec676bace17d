// What must hold for images that are read or written. Private to formats/.
#pragma once

#include <string>

#include "formats/error.h"
#include "formats/image.h"

namespace bakelight::formats {

Error unreadableImage(const std::string& file, const std::string& reason);
Error tooLargeImage(const std::string& file);

// Throws for a value that is NaN or infinite, naming its texel and channel.
void requireFinite(const Image& image, const std::string& file);
// Throws for a value beyond what a half holds.
void requireHalves(const Image& image, const std::string& file);
// Throws std::logic_error for what only a bug can get wrong.
void checkShape(const Image& image);

// What a picture that is black everywhere deserves to be told of, when it is to give light; else "".
std::string noteIfBlack(const Image& image, const std::string& file);

}  // namespace bakelight::formats
