// Where neighborhood transfer is known: rectilinear grids around an object, dense where it is and coarser farther off.
#pragma once

#include <array>
#include <vector>

#include "formats/triangle_mesh.h"
#include "transport/camera.h"

namespace bakelight::neighborhood {

// Coordinates that rise from `low` − reach to `high` + reach: `inner` equal intervals between `low` and `high` (low < high), and on each side `outer`
// more (1 or more), each larger than the one before by the same factor, which is at least 1: where equal ones would go too far, they end at `reach`.
std::vector<float> gradedAxis(double low, double high, int inner, int outer, double reach);

// Of the plane that the lowest vertex lies in: x and z. `cells` intervals along the longer side, three fifths of them across the bounding box;
// `reach` in radii of the bounding sphere.
struct GroundGrid {
  float level = 0;
  std::vector<float> x, z;
};
GroundGrid groundGrid(const formats::TriangleMesh& mesh, const transport::BoundingSphere& bounds, int cells,
                      double reach);

// Of the space around the object and above that plane: `cells` along the longest side.
std::array<std::vector<float>, 3> volumeGrid(const formats::TriangleMesh& mesh,
                                             const transport::BoundingSphere& bounds, int cells,
                                             double reach);

}  // namespace bakelight::neighborhood
