// The interior of a disk within a convex border: one-to-one to begin with (Floater 2003, mean value
// coordinates), then of least texture stretch (Yoshizawa et al. 2004; Sander et al. 2001).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tools/atlas/charts/chart.h"

namespace bakelight::atlas {

// A disk of triangles that are known by their shapes.
struct DiskMesh {
  std::vector<Triangle> triangles;
  std::vector<std::array<Vec2, 3>> shapes;  // of the triangles, laid flat counter-clockwise
  std::vector<double> weights;              // of the triangles' areas in the stretch, positive
  std::vector<std::uint8_t> fixed;          // of the vertices: 1 on the border

  std::size_t vertexCount() const { return fixed.size(); }
};

// Σ weight · area · (Γ² + γ²) / 2, which is what stretch.h's sum is; infinite unless all triangles turn left.
double weightedStretch(const DiskMesh& mesh, const std::vector<Vec2>& plane);

enum class InteriorWeights { kMeanValue, kUniform };

// Each vertex that is not fixed becomes a convex combination of its neighbours; `plane` holds the border. No
// triangle is flipped in exact numbers if the border is convex and no inner edge joins two vertices of one
// straight side; rounding may still flip some. False if the equations could not be solved.
bool solveInterior(const DiskMesh& mesh, InteriorWeights weights, std::vector<Vec2>& plane);

// From a `plane` without flipped triangles to one of less stretch, and never more, without flipped triangles:
// solves in which vertices draw their neighbours the more the more they are stretched, then descent of each
// vertex within its ring, until a sweep gains less than 1e-4 of the stretch. Cost: about 40 µs a triangle.
void minimizeStretch(const DiskMesh& mesh, std::vector<Vec2>& plane);

}  // namespace bakelight::atlas
