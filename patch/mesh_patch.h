// A mesh as the surface of a patch.
#pragma once

#include <string>

#include "formats/material.h"
#include "formats/triangle_mesh.h"
#include "patch/patch_geometry.h"

namespace bakelight::patch {

// The period's lower left corner is that of the mesh's bounds; parts that reach beyond the period (that lie over
// others of the next one) stay. Without normals they are made, with creases. Where the patch is not periodic its
// mirror images continue it. Of the result only mesh, aspect, periods and notes are set. Throws Error(kBadInput)
// naming `file`: no triangle, no extent across or up the patch, more than 4 periods across, higher than 100 widths.
PatchGeometry meshPatch(const formats::TriangleMesh& mesh, const formats::PatchMesh& settings, bool periodic,
                        const std::string& file);

}  // namespace bakelight::patch
