// Distant light as a cube map of mean radiance, for transfer in a pixel basis: nothing of its energy is lost, however small a
// light is.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "formats/image.h"
#include "formats/light_rig.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

// Mean radiance over each of 6 · side² texels (cube_map.h), of all `lights` together, turned by `object_from_light`. Texel by texel, Σ radiance ×
// solid angle is what the lights send: images give each of their texels' light to where it falls, shapes have their exact solid
// angle, a directional light is in one texel. Which texel an edge falls in is found by points, some 24 × 24 a texel of the cube. The same bytes whatever the number of
// threads. Throws Error(kBadInput) as projectLight for images and polygons that are none, and for light that is not finite. Cost: for images some 6 · (24 side)²
// points.
std::vector<Float3> cubeLight(std::span<const formats::DistantLight> lights, int side,
                              const Eigen::Matrix3d& object_from_light);

// Adds a cube map, a strip 6:1 of faces of channels R, G, B whose resolution is a multiple of `side`: means over blocks of texels by their
// solid angles.
void addCubeMap(const formats::Image& strip, int side, std::span<Float3> radiance);
// The least such resolution from `resolution_px` on.
int cubeResolutionFor(int side, int resolution_px);

}  // namespace bakelight::transport
