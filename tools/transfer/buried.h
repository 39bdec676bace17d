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
// rather than in a closed cavity (front faces), where only bounced light can be. `origin` is off the surface,
// as for the shadow rays.
bool isBuried(const transport::RayScene& scene, const formats::Float3& origin, const formats::Float3& normal);

// Gives each buried vertex the mean row of its neighbours, ring by ring from where the surface comes out. A
// component that is buried as a whole stays as it is: nobody sees it. Linear in the table.
class BuriedFill {
 public:
  BuriedFill() = default;
  // `buried` has one entry a vertex.
  BuriedFill(const formats::TriangleMesh& mesh, std::span<const std::uint8_t> buried);

  std::uint64_t filledVertices() const { return steps_.size(); }
  // `table` has at least one row of `row_size` a vertex.
  void apply(std::span<float> table, std::size_t row_size) const;

 private:
  struct Step {
    std::uint32_t vertex;
    std::vector<std::uint32_t> sources;  // done before it
  };
  std::vector<Step> steps_;
};

}  // namespace bakelight::transfer
