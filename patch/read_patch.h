// The surface of a material's patch, from its files.
#pragma once

#include "formats/material.h"
#include "patch/patch_geometry.h"

namespace bakelight::patch {

// `material.patch` has a surface (Patch::hasSurface). Its albedo is that of the patch (color and picture multiply
// each other), else the mesh's colors, else the material's albedo, else formats::kDefaultAlbedo. Throws
// Error(kBadInput) as readImage, readColorPicture, importMesh, heightField and meshPatch do.
PatchGeometry readPatch(const formats::Material& material);

}  // namespace bakelight::patch
