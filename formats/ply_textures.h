// Pictures that the header of a PLY file names in comments, as MeshLab does. Private to the importers.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "formats/named_file.h"
#include "formats/ply_header.h"

namespace bakelight::formats {

// The names, in the header's order: `texnumber` of a face counts them from 0.
std::vector<std::string> plyTextureNames(const PlyHeader& header);

// Where they are, or should be. None if `bytes` are no PLY file.
std::vector<std::filesystem::path> plyTextures(std::span<const std::byte> bytes,
                                               const std::filesystem::path& file, const FileLookup& files);

}  // namespace bakelight::formats
