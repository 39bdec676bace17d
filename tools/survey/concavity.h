// How far a mesh is from being convex, as light sees it: whether anything rises above the plane of a front.
#pragma once

#include "formats/triangle_mesh.h"

namespace bakelight::survey {

// Largest height of any used vertex above the plane of any triangle with an area, ÷ the bounding sphere's
// radius; 0 if none rises above any. Then no front is blocked, whatever its normal between those of the
// triangles around it, and transfer is the unshadowed closed form. The sides that are lit count, so an open
// sheet or cap seen from outside has 0 and seen from inside more; so have two bodies that see each other, and
// a closed body with its windings turned.
//
// From a height goes what rounding of the float positions can account for, δ(2 + 3r/h): δ half an ulp of the
// largest coordinate in each axis, r the distance of the vertex from the triangle's centroid, h the
// triangle's smallest height. So a finely divided face of a turned box is flat, and a dent is seen however
// fine.
//
// Exact up to that: branch and bound over a tree of oriented boxes. Cost, for n vertices: n log n on curved
// surfaces; n √n where large flat faces are finely divided. On all TBB threads; the same value whatever their
// number.
double concavity(const formats::TriangleMesh& mesh);

}  // namespace bakelight::survey
