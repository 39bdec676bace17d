// Lightings from files.
#pragma once

#include <filesystem>

#include "tools/player/lighting.h"

namespace bakelight::player {

// The sum of an environment image and a light rig; either path may be empty, and with both empty it is the
// default light. `windowing`: 0 leaves the rig's own, else as in formats::LightRig. Throws what
// formats::readImage, formats::readLightRig and the functions of lighting.h throw.
Lighting readLighting(const std::filesystem::path& environment_path, const std::filesystem::path& rig_path,
                      int order, double windowing = 0);

}  // namespace bakelight::player
