// Where rays start that gather light at the vertices of a mesh.
#pragma once

#include <cstdint>
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

// A place of a triangle of a mesh with normals, as a smooth surface through the vertices has it.
struct SmoothPoint {
  Vec3 position;  // on the triangle
  Vec3 normal;    // interpolated, unit; the triangle's own where normals cancel out
  Vec3 lifted;    // out to the vertices' tangent planes where these lie above the triangle, interpolated
};
// By the weights of the second and third corner; weights outside of the triangle count as those of its edge. `side` is 1, or −1 to see the triangle's
// clockwise side. Rays that start at `lifted` do not meet a smooth convex body at once (Hanika 2021, "Hacking the Shadow Terminator", Ray Tracing
// Gems II, chapter 4); off it by surfaceOffset, neither do those of rounded numbers.
SmoothPoint smoothPoint(const formats::TriangleMesh& mesh, std::uint32_t triangle, double u, double v,
                        double side = 1);

// The share of the bounding sphere's radius that tools start rays off the surface by, if nothing else is
// said.
inline constexpr double kDefaultBias = 1e-4;

}  // namespace bakelight::transport
