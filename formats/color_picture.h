// A picture's colour, whatever it is stored as: the layer that is a colour, upright, linear.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/image.h"

namespace bakelight::formats {

struct ColorPicture {
  Image image;                     // R, G, B, linear
  bool decoded = false;            // its integer codes were sRGB
  std::vector<std::string> notes;  // what a user should know of it, each naming the file
};

enum class PictureUse { kLight, kReflectance };

// The colour is R, G and B (any case; "red", "green", "blue", too) without a layer's name; else those of the
// only layer that has them, or of the one called "Combined", "beauty", "RGBA", "rgb" or "color"; else a
// single grey channel. All parts of an OpenEXR file are looked through, the first that has a colour counts;
// depth, alpha and other channels are ignored, finite or not. Integer codes are decoded by the sRGB curve
// unless the file says that they are linear; for light that is noted, as is a picture that is black
// everywhere. Throws Error(kBadInput) as readImage does, and naming the channels if none or several of them
// are a colour.
ColorPicture readColorPicture(const std::filesystem::path& path, PictureUse use);

}  // namespace bakelight::formats
