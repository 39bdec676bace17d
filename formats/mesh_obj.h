// OBJ files (Alias|Wavefront) with their material libraries. Private to the importers.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "formats/mesh_parts.h"
#include "formats/named_file.h"

namespace bakelight::formats {

// One part. Vertices without texture coordinates and normals keep the file's order; otherwise there is one
// for each combination that a corner has, in order of appearance. Materials are those that `usemtl` names, in
// order of first naming. docs/FORMATS.md says what is read and what is left out.
// Throws Error(kBadInput) naming `file` and its line. Cost: linear; 36 bytes a triangle beside the result.
MeshParts readObj(std::string_view text, const std::filesystem::path& file, const FileLookup& files);

// The material libraries that `text` names and the pictures that these name, whether they are there or not.
std::vector<std::filesystem::path> objCompanions(std::string_view text, const std::filesystem::path& file,
                                                 const FileLookup& files);

}  // namespace bakelight::formats
