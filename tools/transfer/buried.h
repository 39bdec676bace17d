// Vertices inside another part of the mesh. They see nothing but the insides of surfaces, and no viewer ever
// sees them, but the triangles that reach out of the other part interpolate towards them: left at zero they
// show as black stains.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/triangle_mesh.h"
#include "transport/ray_scene.h"

namespace bakelight::transfer {

// Whether a vertex that sees no light sits inside a solid (most of what its hemisphere meets are back faces)
// rather than in a closed cavity (front faces), where zero is the right answer. `origin` is off the surface,
// as for the shadow rays.
bool isBuried(const formats::TriangleMesh& mesh, const transport::RayScene& scene,
              const formats::Float3& origin, const formats::Float3& normal);

// Gives each buried vertex the mean vector of its neighbours, ring by ring from where the surface comes out.
// A component that is buried as a whole stays at zero: nobody sees it. `vectors` is n × count. Returns how
// many vertices were filled.
std::uint64_t fillBuried(const formats::TriangleMesh& mesh, std::span<const std::uint8_t> buried,
                         std::span<float> vectors, std::size_t count);

}  // namespace bakelight::transfer
