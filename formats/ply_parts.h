// PLY files of any kind (Turk 1994), for the importer. formats/mesh_ply.h has the strict reader of those
// between stages.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "formats/mesh_parts.h"
#include "formats/named_file.h"

namespace bakelight::formats {

// One part; vertices keep the file's order, and are followed by copies where the corners of faces differ.
// docs/FORMATS.md says which elements and properties are read. Throws Error(kBadInput) naming `file` and the
// element (counted from 0), in a text with its line. Cost: linear.
MeshParts readPlyParts(std::span<const std::byte> bytes, const std::filesystem::path& file,
                       const FileLookup& files);

// The pictures that its header names, whether they are there or not; none if it is no PLY.
std::vector<std::filesystem::path> plyCompanions(std::span<const std::byte> bytes,
                                                 const std::filesystem::path& file, const FileLookup& files);

}  // namespace bakelight::formats
