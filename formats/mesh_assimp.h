// Formats without a reader of our own, through assimp 5.2: FBX, COLLADA (DAE), 3DS and whatever else it
// reads. Private to the importer.
#pragma once

#include <filesystem>

#include "formats/mesh_parts.h"

namespace bakelight::formats {

// +Y up, as noted: FBX files say where up is, COLLADA files too, 3DS files have +Z up by convention; others
// are left as they are. COLLADA comes in metres, as its files say how many a unit has; FBX is left in the
// file's own unit, whose size is noted.
//
// Each mesh of each node is a part, its node's transform applied, polygons triangulated. Materials have their
// diffuse colour (linear, as exporters write it), or the diffuse picture in its place. Formats that have a
// reader of our own are not tried, whatever the ending.
//
// Throws Error(kBadInput) naming `path`: not readable, an index out of range, a face without corners, a
// position that is not finite.
MeshParts readWithAssimp(const std::filesystem::path& path);

}  // namespace bakelight::formats
