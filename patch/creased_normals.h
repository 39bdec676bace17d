// Normals of a periodic surface, with vertices split along its creases.
#pragma once

#include "formats/triangle_mesh.h"

namespace bakelight::patch {

// Edges sharper than this keep their facets apart.
inline constexpr double kCreaseAngle_deg = 50;

// At each corner the mean, by angle, of the normals of the triangles around its place that differ by at most
// the crease angle from its own triangle's. Places are told apart modulo the periods, to 10⁻⁶ of the larger.
// Vertices whose corners have different normals are split. Triangles without area take part in nothing and get
// the normal +z where nothing else is there. The order of triangles stays; so do colors and names.
formats::TriangleMesh withCreasedNormals(const formats::TriangleMesh& mesh, double period_x, double period_y,
                                         double crease_angle_deg = kCreaseAngle_deg);

}  // namespace bakelight::patch
