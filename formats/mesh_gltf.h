// glTF 2.0, text and binary. Private to the importer; docs/FORMATS.md says what is read of it.
#pragma once

#include <filesystem>

#include "formats/file.h"
#include "formats/mesh_parts.h"

namespace bakelight::formats {

// The default scene: each primitive of each node as a part, with morph targets at their default weights,
// skins at the pose of their joints, instances, and the node's transform, in double precision and rounded
// once. Text or binary is told by the content; other files that it names are looked for beside `path`.
//
// Throws Error(kBadInput) with the JSON pointer of what is wrong: not glTF 2.x, a required extension that is
// not known, a reference to nothing, data that end too early, an index out of range, a position that is not
// finite. Whatever the bytes are, it returns or throws Error. Cost: linear in the file.
MeshParts readGltf(const std::filesystem::path& path, const Bytes& bytes);

}  // namespace bakelight::formats
