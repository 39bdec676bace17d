// What the repair takes away that a person would want to know of.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"
#include "surface/repair.h"

namespace bakelight::surface {

// Throws Error(kBadInput) naming `file`, and the vertex, for meshes farther out than 1e18 or smaller than
// 1e-18 units: past those, products of lengths leave the range of the floats that later stages work in.
void checkScale(const formats::TriangleMesh& mesh, const std::string& file);

// Where most of a mesh is.
struct Extent {
  Eigen::AlignedBox3d box;  // of the vertices that triangles use
  // That of the middle 98% of them along each axis, if `box` is a thousand times larger.
  std::optional<Eigen::AlignedBox3d> bulk;

  const Eigen::AlignedBox3d& working() const { return bulk ? *bulk : box; }
};
Extent extentOf(const WorkingMesh& mesh);

// Triangles that the weld or the file's single precision made collapse, that repeat others, or lay back to
// back on others and were removed, where they are more than one in a hundred; vertices far out of the bulk;
// coordinates so far from the origin that floats are no finer than a fiftieth of the edges; parts turned
// inside out. Lengths in the unit of `mesh`, as is `weld_tolerance`.
std::vector<std::string> lossWarnings(const formats::TriangleMesh& mesh, const Extent& extent,
                                      double weld_tolerance, const RepairCounts& counts);

// Triangles of the result that its own rounding to floats has made collapse, if there are any.
std::vector<std::string> roundingWarnings(const formats::TriangleMesh& result);

}  // namespace bakelight::surface
