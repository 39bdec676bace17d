// Light rigs on disk (docs/FORMATS.md has the keys).
#pragma once

#include <filesystem>

#include "formats/light_rig.h"

namespace bakelight::formats {

// Reads the file and the images and meshes it names (relative to it). Throws Error(kBadInput) naming file and
// JSON pointer for an unknown key (with the nearest valid one), a wrong type, a value out of range, or a rig
// without any light.
LightRig readLightRig(const std::filesystem::path& path);

}  // namespace bakelight::formats
