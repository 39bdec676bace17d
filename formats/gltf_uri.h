// What the URIs in a glTF file mean (RFC 3986, RFC 2397), and which files they name.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/file.h"

namespace bakelight::formats {

// "%20" becomes a space; what is no escape stays as it is.
std::string percentDecoded(std::string_view text);

bool isDataUri(std::string_view uri);

// What a data URI holds, or what is wrong with it. Base64 as in RFC 4648, of either alphabet, with or without
// padding; white space in it is skipped.
struct DataUri {
  Bytes bytes = {};
  std::string media_type = {};
  std::string fault = {};  // empty: none
};
DataUri readDataUri(std::string_view uri);

// "data:image/png;base64,…".
std::string dataUri(std::string_view media_type, std::span<const std::byte> bytes);

// Where the file of a URI that is no data URI may lie, best first: URIs should be escaped, yet exporters
// write bare names and backslashes. Relative paths are relative to the glTF file. Empty if it names no file
// (http:…).
std::vector<std::filesystem::path> pathsOfUri(std::string_view uri);

// All paths that a glTF file (text or binary) names for its buffers and images, sorted: what its content
// depends on, whether there or not. Relative to its folder. None if the bytes are no glTF file.
std::vector<std::filesystem::path> gltfCompanions(std::span<const std::byte> bytes);

// The JSON of a text or binary glTF file as far as it is there, without any check of its container.
std::string_view gltfJson(std::span<const std::byte> bytes);

}  // namespace bakelight::formats
