// Readers of meshes that take assimp, in a module (module.h). Private to the importers.
#pragma once

#include <filesystem>

#include "formats/mesh_parts.h"

namespace bakelight::formats {

// The module's bakelight_mesh_readers() returns its own. What mesh_assimp.h promises.
struct MeshReaders {
  MeshParts (*read_with_assimp)(const std::filesystem::path& path);
};

}  // namespace bakelight::formats
