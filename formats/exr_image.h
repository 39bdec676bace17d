// Ordinary OpenEXR files straight through the OpenEXR library. Private to formats/.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "formats/file.h"
#include "formats/image.h"
#include "formats/index_image.h"

namespace bakelight::formats {

// An OpenEXR file of one flat part that fills its frame, with channels in the order of OpenImageIO: by layer,
// red, green, blue, alpha and depth first. Values are not looked at. Nothing for any other file, and for what
// cannot be read: the readers that know all kinds judge that. Throws std::bad_alloc.
std::optional<Image> readPlainExr(const std::filesystem::path& path);

// Its string attributes, unless some have a meaning to OpenEXR, which OpenImageIO calls by other names.
std::optional<std::map<std::string, std::string>> plainExrMetadata(const std::filesystem::path& path);

// The bytes of a file: scan lines, zip compression. The same on any number of threads.
Bytes encodedExr(const Image& image, ExrPrecision precision,
                 const std::map<std::string, std::string>& metadata);

// Channels of 32-bit unsigned integers.
Bytes encodedExr(const IndexImage& image, const std::map<std::string, std::string>& metadata);

}  // namespace bakelight::formats
