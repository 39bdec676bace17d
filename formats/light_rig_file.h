// Light rigs on disk (docs/LIGHTS.md has the keys).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/light_rig.h"

namespace bakelight::formats {

// Reads the file and the images and meshes it names (relative to it). Throws Error(kBadInput) naming file and
// JSON pointer for an unknown key (with the nearest valid one), a wrong type, a value out of range, or a rig
// without any light.
LightRig readLightRig(const std::filesystem::path& path);

// All lights that tools are given by --environment (a lat-long image) and --lights (a rig): their sum. Either
// path may be empty; both empty is a rig without lights. `windowing`, where given, replaces the rig's.
// Throws what readColorPicture and readLightRig throw.
LightRig readLights(const std::filesystem::path& environment_path, const std::filesystem::path& rig_path,
                    std::optional<double> windowing = {});

// What a tool should warn of: pictures that were decoded, or are black.
std::vector<std::string> notesOn(const LightRig& rig);

}  // namespace bakelight::formats
