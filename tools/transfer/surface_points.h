// Where a bake gathers light: the front of every vertex and, on open surfaces, the back of those that bounced
// light comes from.
#pragma once

#include <cstdint>
#include <vector>

#include "formats/triangle_mesh.h"
#include "transport/surface_points.h"
#include "transport/vector_types.h"

namespace bakelight::transfer {

using formats::Float3;

using transport::frontPoints;
using transport::surfaceOffset;
using transport::SurfacePoint;

// The back of vertex v: the same distance off the surface on the other side.
SurfacePoint backPoint(const formats::TriangleMesh& mesh, const SurfacePoint& front, std::uint32_t vertex);

// What a ray meets that hits a triangle from behind: for its three corners, in their order, the side of a
// vertex (v its front, v + vertex count its back). Of a sheet given twice, once for each side, it is the
// front of the other triangle; on a component with an open border the backs of the corners; in the inside of
// a closed component it is kDarkSide. Vertices at the same place count as one, so creases are no borders.
inline constexpr std::uint32_t kDarkSide = ~std::uint32_t{0};
std::vector<formats::Triangle> sidesFromBehind(const formats::TriangleMesh& mesh);

// Tangents of local frames where any will do: xyz, and w = 1 (bitangent = w · normal × tangent). From the
// normal alone (transport::anyTangent).
std::vector<formats::Float4> vertexTangents(const formats::TriangleMesh& mesh);
// Rows t, b, n: local coordinates of a direction in the object.
Eigen::Matrix3d localFromObject(const Float3& normal, const formats::Float4& tangent);

}  // namespace bakelight::transfer
