// Materials of a scene that assimp has read. Private to formats/mesh_assimp.cpp.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/mesh_parts.h"

struct aiMaterial;
struct aiScene;

namespace bakelight::formats {

// How a material looks its picture up: a set of coordinates, scaled, turned about the middle, moved.
struct AssimpLookup {
  unsigned set = 0;
  std::array<double, 2> scale = {1, 1}, offset = {0, 0};
  double rotation = 0;

  bool isPlain() const { return *this == AssimpLookup{}; }
  bool operator==(const AssimpLookup&) const = default;
};

struct AssimpMaterials {
  // Of each of assimp's materials its place among `materials`; −1 for the one that assimp makes up for meshes
  // without a material.
  std::vector<int> places;
  std::vector<PartMaterial> materials;
  std::vector<std::optional<AssimpLookup>> lookups;  // of materials with a texture
  std::vector<AlbedoTexture> textures;
};

// Pictures are looked for beside `path`, or taken out of the file; one that is not there is noted, and its
// material is left with its colour.
AssimpMaterials assimpMaterials(const aiScene& scene, const std::filesystem::path& path,
                                std::vector<std::string>& notes);

}  // namespace bakelight::formats
