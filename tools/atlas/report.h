// What the atlas stage writes beside the mesh: stats, and the tables of charts.
#pragma once

#include <string>

#include "formats/json.h"
#include "formats/tensors.h"
#include "tools/atlas/make_atlas.h"

namespace bakelight::atlas {

formats::Json toJson(const AtlasReport& report);

// Tensors, all uint32: "triangle_charts" and "source_triangles" a triangle of the atlas, "source_vertices" a
// vertex. Metadata: charts, resolution, gutter, border, texels_per_unit, and geometry_hash of the atlas's
// mesh.
formats::TensorFile chartTables(const AtlasResult& result, const AtlasOptions& options);

}  // namespace bakelight::atlas
