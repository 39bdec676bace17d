// Tangents along texture coordinates: the frames in which a patch lies that is laid out by them.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::transport {

struct TextureFrames {
  // One a vertex: xyz, unit, perpendicular to the normal, along growing u; w = 1 or −1, so that w · normal ×
  // tangent points along growing v. Mean of the triangles around the vertex, by area.
  std::vector<formats::Float4> tangents;
  std::size_t undetermined = 0;  // vertices whose triangles have no direction of u: any tangent
  std::size_t mirrored = 0;      // vertices with w = −1
};

// Throws std::invalid_argument unless there is a normal and a texture coordinate a vertex.
TextureFrames textureFrames(const formats::TriangleMesh& mesh);

// Length on the surface of a unit of texture coordinates: √(area ÷ area in the plane), of the whole mesh; 1 if
// either is nothing.
double surfaceUnitOf(const formats::TriangleMesh& mesh);

// How patches of about this width (nothing: as wide as a unit of texture coordinates) repeat along texture coordinates: whole ones
// to a unit of these, so that what they close stays closed.
struct PatchRepeats {
  double repeats = 1;  // patches to a unit of u
  double width = 1;    // of a patch then, on the surface
};
PatchRepeats patchRepeats(const formats::TriangleMesh& mesh, std::optional<double> width);

// A tangent of a unit normal from it alone, without the pole that a fixed axis has (Duff et al. 2017, "Building
// an Orthonormal Basis, Revisited"); w = 1. Orthonormal to rounding.
formats::Float4 anyTangent(const formats::Float3& normal);

// The part of `direction` that is perpendicular to `normal`, of unit length; anyTangent if there is none.
formats::Float4 tangentAlong(const formats::Float3& direction, const formats::Float3& normal,
                             float handedness);

}  // namespace bakelight::transport
