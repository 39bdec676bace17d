// Files that a mesh file names and that belong to its content: material libraries, their textures, buffers.
#pragma once

#include <filesystem>
#include <vector>

#include "formats/named_file.h"

namespace bakelight::formats {

// What importMesh would read beside `mesh`, whether it is there or not; each where it is, or where its name
// says that it should be. Of .dae, .fbx and .3ds all pictures whose name is anywhere in the file, some of
// which may be of no use. None for files that are damaged: importMesh says what is wrong with them. Throws
// Error(kBadInput) if `mesh` cannot be read. Cost: a look at each line of an OBJ, at the header of a PLY, at
// the JSON of a glTF, at each byte of the others.
std::vector<std::filesystem::path> meshCompanions(const std::filesystem::path& mesh, const FileLookup& files);

}  // namespace bakelight::formats
