// Which way is up, and how long a unit is, in a scene that assimp has read. Private to
// formats/mesh_assimp.cpp.
#pragma once

#include <string>
#include <vector>

#include "formats/mesh_transform.h"

struct aiScene;

namespace bakelight::formats {

// What turns the scene upright (+Y up, right-handed) after all that assimp itself has done; both are noted.
// `ending` in lowercase, with the dot.
Transform uprightFromScene(const aiScene& scene, const std::string& ending, std::vector<std::string>& notes);

}  // namespace bakelight::formats
