// Figures of what shows where in a patch: meso-meshes and id maps.
#pragma once

#include <vector>

#include "formats/index_image.h"
#include "formats/meso_mesh.h"
#include "tools/inspect/summary.h"

namespace bakelight::inspect {

std::vector<Section> describeMesoMesh(const formats::MesoMesh& meso);
// `ids` has the channels of patch_preview.h's readIdMap().
std::vector<Section> describeIdMap(const formats::IndexImage& ids);

}  // namespace bakelight::inspect
