// A picture's colour, whatever it is stored as: the layer that is a colour, upright, linear.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
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

// Whether the picture is turned as its file says (Exif), or taken as it is stored, as glTF has it.
enum class PictureTurn { kAsFileSays, kAsStored };

// The colour is R, G and B (any case; "red", "green", "blue", too) without a layer's name; else those of the
// only layer that has them, or of the one called "Combined", "beauty", "RGBA", "rgb" or "color"; else a
// single grey channel. All parts of an OpenEXR file are looked through, the first that has a colour counts;
// depth, alpha and other channels are ignored, finite or not. Integer codes are decoded by the sRGB curve
// unless the file says that they are linear; for light that is noted, as is a picture that is black
// everywhere. Throws Error(kBadInput) as readImage does, and naming the channels if none or several of them
// are a colour.
ColorPicture readColorPicture(const std::filesystem::path& path, PictureUse use,
                              PictureTurn turn = PictureTurn::kAsFileSays);

// The same from the bytes of a picture's file (PNG, JPEG, GIF, BMP, TIFF, WebP, DDS, Targa, EXR,
// Radiance); `name` is for messages.
ColorPicture readColorPicture(std::span<const std::byte> bytes, const std::string& name, PictureUse use,
                              PictureTurn turn = PictureTurn::kAsFileSays);

}  // namespace bakelight::formats
