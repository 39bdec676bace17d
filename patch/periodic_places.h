// Which vertices of a periodic surface are at one place.
#pragma once

#include <cstdint>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::patch {

// For each vertex the first one at its place, modulo the periods, to 10⁻⁶ of the larger.
std::vector<std::uint32_t> periodicPlaces(const formats::TriangleMesh& mesh, double period_x,
                                          double period_y);

}  // namespace bakelight::patch
