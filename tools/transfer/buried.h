// Vertices inside another part of the mesh. They see nothing but the insides of surfaces, and no viewer ever
// sees them, but the triangles that reach out of the other part interpolate towards them: left at zero they
// show as black stains.
#pragma once

#include <cstdint>

#include "formats/triangle_mesh.h"
#include "transport/ray_scene.h"

namespace bakelight::transfer {

// Whether a vertex that sees no light sits inside a solid (most of what its hemisphere meets are back faces)
// rather than in a closed cavity (front faces), where only bounced light can be. `origin` is off the surface,
// as for the shadow rays.
bool isBuried(const transport::RayScene& scene, const formats::Float3& origin, const formats::Float3& normal);

}  // namespace bakelight::transfer
