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
//   coverage      0: no surface. 1: the texel's centre lies in a triangle. 2: a triangle overlaps the texel,
//   but none its
//                 centre. 3: border: within `border` texels of a chart, and on the surface beyond the chart's
//                 edge.
//   chart         number of the chart, −1 where coverage is 0
//   triangle      number of the triangle of the mesh, −1 where coverage is 0
//   barycentric.U, barycentric.V   weights of the triangle's second and third corner
//   position.X, .Y, .Z
//   normal.X, .Y, .Z     interpolated, unit length
//   tangent.X, .Y, .Z    unit length, at right angles to the normal, along growing u
//   handedness           ±1: bitangent = handedness · normal × tangent. Readers take the frame from here.
//   area          area of the surface inside the texel, in the asset's unit squared: exact; 0 where coverage
//   is 3
//
// Centres are judged exactly; one on an edge belongs to one triangle (top-left rule, in exact arithmetic), so
// no texel is claimed twice and none is missed. Texels of coverage 2 take the nearest point of the chart.
// Those of coverage 3 take the point that is reached by walking straight on over the surface from the nearest
// point of the chart's edge, as far as the texel is away (Lensch et al. 2002, 5.1 takes whole neighbouring
// triangles, which it has to distort); where the surface ends, nothing. A texel that two charts touch goes to
// the one with the larger area in it.
//
// Throws Error(kBadInput) naming `file` and face if a texture coordinate lies outside [0, 1], or there are
// more than 2^24 triangles, which float channels cannot number. Cost: O(triangles + texels); threads by TBB,
// same bytes for any number.
formats::Image geometryMaps(const Atlas& atlas, const GeometryMapOptions& options, const std::string& file);

}  // namespace bakelight::atlas
