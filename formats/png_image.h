// PNG through libpng. Private to formats/.
#pragma once

#include <string>

#include "formats/file.h"
#include "formats/image.h"

namespace bakelight::formats {

// 8-bit sRGB; 1 to 4 channels, which are grey, grey and alpha, RGB, RGBA. `file` is for messages.
Bytes encodedPng(const Image& image, const std::string& file);

}  // namespace bakelight::formats
