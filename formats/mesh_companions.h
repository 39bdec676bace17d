// Files that a mesh file names and that belong to its content: material libraries, their textures, buffers.
#pragma once

#include <filesystem>
#include <vector>

#include "formats/named_file.h"

namespace bakelight::formats {

// What importMesh would read beside `mesh`, whether it is there or not; each where it is, or where its name
// says that it should be. None for files of other endings than .obj, .ply, .gltf and .glb, and for those that
// are damaged: importMesh says what is wrong with them. Throws Error(kBadInput) if `mesh` cannot be read.
// Cost: a look at each line of an OBJ, at the header of a PLY, at the JSON of a glTF.
std::vector<std::filesystem::path> meshCompanions(const std::filesystem::path& mesh, const FileLookup& files);

}  // namespace bakelight::formats
