// A picture of a direction field.
#pragma once

#include <string>

#include "formats/meso_mesh.h"
#include "tools/inspect/preview.h"

namespace bakelight::inspect {

// A triangle around which the tangents turn: by `index` · 360°/symmetry more than the surface does.
struct TurningTriangle {
  std::uint32_t triangle = 0;
  int index = 0;
};
// In the plane of each triangle; those without area turn nowhere.
std::vector<TurningTriangle> turningTriangles(const formats::MesoMesh& meso);

// Strokes on clay, evenly over the picture, and a dot at each singularity. Throws Error(kBadInput) naming
// `file` if the mesh has no extent.
Preview drawDirections(const formats::MesoMesh& meso, const PreviewOptions& options, const std::string& file);

}  // namespace bakelight::inspect
