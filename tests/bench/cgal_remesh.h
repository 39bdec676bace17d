// CGAL's isotropic remeshing, for the benchmark to stand beside. Its package is GPL-3: no tool links it.
#pragma once

#include "formats/triangle_mesh.h"

namespace bakelight::tests {

struct CgalTiling {
  double vertices = 0, mean_quality = 0;  // 4√3·area ÷ Σ side²
  double seconds = 0;
};

// Polygon_mesh_processing::isotropic_remeshing at the edge length of an even tiling of as many vertices.
CgalTiling cgalRemeshing(const formats::TriangleMesh& mesh, double vertices, unsigned iterations);

}  // namespace bakelight::tests
