// Where rays start that gather light at the vertices of a mesh.
#pragma once

#include <vector>

#include "formats/triangle_mesh.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

struct SurfacePoint {
  Float3 origin;  // where its rays start
  Float3 normal;
};

// Distance by which rays start off the surface: `bias` × the bounding sphere's radius, at least four
// roundings of the coordinates.
float surfaceOffset(const formats::TriangleMesh& mesh, double bias);

// Point v is the front of vertex v. A vertex on a crease (a copy at the same place has another normal) is
// also moved into its own triangles, since off the surface along its normal it would lie in the plane of the
// next face.
std::vector<SurfacePoint> frontPoints(const formats::TriangleMesh& mesh, double bias);

// The share of the bounding sphere's radius that tools start rays off the surface by, if nothing else is
// said.
inline constexpr double kDefaultBias = 1e-4;

}  // namespace bakelight::transport
