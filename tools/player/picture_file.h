// Between the player's structs and image files.
#pragma once

#include <filesystem>

#include "tools/player/frame.h"
#include "tools/player/headless.h"

namespace bakelight::player {

// By the ending: .png or .exr, in any case of letters. Throws Error(kUsage) for another one.
PictureEncoding encodingFor(const std::filesystem::path& picture_path);

// Throws what formats::readImage and environmentFromImage throw.
Environment readEnvironment(const std::filesystem::path& path, int order);

// 8-bit PNG, or OpenEXR of 32-bit floats. Atomic.
void writePicture(const std::filesystem::path& path, const formats::Image& image, PictureEncoding encoding);

}  // namespace bakelight::player
