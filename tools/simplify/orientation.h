// Turning a mesh that was not modelled with +Y up.
#pragma once

#include <string>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::simplify {

// "y", "-y", "z", "-z", "x", "-x".
const std::vector<std::string>& upAxes();

// Rotates positions and normals by quarter turns so that `up_axis`, one of upAxes(), becomes +Y. Exact:
// coordinates change places and signs only. Throws std::invalid_argument for another name.
void turnUpright(formats::TriangleMesh& mesh, const std::string& up_axis);

}  // namespace bakelight::simplify
