// Pictures as image files.
#pragma once

#include <filesystem>

#include "tools/player/headless.h"

namespace bakelight::player {

// By the ending: .png or .exr, in any case of letters. Throws Error(kUsage) for another one.
PictureEncoding encodingFor(const std::filesystem::path& picture_path);

// 8-bit PNG, or OpenEXR of 32-bit floats. Atomic.
void writePicture(const std::filesystem::path& path, const formats::Image& image, PictureEncoding encoding);

}  // namespace bakelight::player
