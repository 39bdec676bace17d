// What surface lies under each texel of an atlas.
#pragma once

#include <string>

#include "formats/image.h"
#include "tools/atlas/atlas.h"

namespace bakelight::atlas {

struct GeometryMapOptions {
  int resolution = 1024;  // texels, of the square's side
  int border = 0;         // texels, see coverage 3 below
};

// Channels of the image, whose top row is that of v = 1:
//   coverage
//     0  no surface
//     1  the texel's centre lies in a triangle
//     2  a triangle meets the texel, but none its centre: the point of the chart nearest to the centre
//     3  border: at most `border` texels, in row, column and diagonal, from one of a chart's coverage 1 or 2
//   chart                number of the chart, −1 where coverage is 0
//   triangle             number of the triangle of the mesh, −1 where coverage is 0; 3: maybe of another
//   chart barycentric.U, .V    weights of the triangle's second and third corner position.X, .Y, .Z normal.X,
//   .Y, .Z     interpolated, unit length; the triangle's where the mesh has none tangent.X, .Y, .Z    unit
//   length, at right angles to the normal, along growing u handedness           ±1: bitangent = handedness ·
//   normal × tangent, along growing v; 0 where coverage is 0 area                 of the surface in the
//   texel, in the asset's unit squared; 0 where coverage is 3
// Readers take the frame from here; nobody derives it again.
//
// Centres are judged exactly; one on an edge belongs to one triangle (top-left rule), so that no texel is
// claimed twice and none is missed. Where charts share a texel, it goes to the one that has its centre, else
// to the one with the larger area in it; its `area` is that of all. Where triangles overlap, a centre goes to
// the first. Areas add up to the surface's, but for triangles without an area in the plane.
//
// Coverage 3 goes on where the surface does (Lensch et al. 2002, section 5.1, takes whole neighbouring
// triangles, which it has to distort): from the nearest point of the chart's edge straight on over the
// surface, as far as the texel is away at the chart's mean scale, and at the same angle with the edge. So it
// is isometric beyond the edge, and the frame is carried along. Where the surface ends before, coverage is 0.
// Where two charts reach a texel, the nearer (in rows and columns) has it, of equally near ones the first.
//
// Throws Error(kBadInput) naming `file` and face: a texture coordinate outside [0, 1]; more than 2^24
// triangles, which float channels cannot number; with a border whatever surfaceOf() throws. Needs texcoords.
// Cost: O(triangles + texels); threads by TBB, same bytes for any number.
formats::Image geometryMaps(const Atlas& atlas, const GeometryMapOptions& options, const std::string& file);

}  // namespace bakelight::atlas
