// The patches of materials as the geometry they are, on the surface that they lie on by its texture coordinates.
#pragma once

#include <string>
#include <vector>

#include "formats/material.h"
#include "tools/reference/scene.h"

namespace bakelight::reference {

// Whether any of them has a patch with a surface.
bool hasPatches(const formats::Materials& materials);

struct PatchedSurface {
  Surface surface;
  std::vector<std::string> notes;  // what a user should know
};

// Faces of materials whose patch has a surface are replaced by it (patch/tiling.h); the others stay. A patch is as
// wide as its material says, else as a unit of texture coordinates, as packs have it. Throws Error(kBadInput) as
// patch::readPatch and patch::tiled do.
PatchedSurface withPatches(const Surface& surface, const formats::Materials& materials,
                           const std::string& mesh_file);

}  // namespace bakelight::reference
