// Which pixels may see anything at all.
#pragma once

#include <cstdint>
#include <vector>

#include "formats/triangle_mesh.h"
#include "transport/camera.h"

namespace bakelight::reference {

// 1 for each pixel that a ray through it may hit a triangle in, row by row from the top: those in a
// triangle's bounding box on the picture, and a pixel around it. All of them if a triangle reaches behind the
// eye.
std::vector<std::uint8_t> possiblyCovered(const formats::TriangleMesh& mesh,
                                          const transport::OrbitCamera& camera, int width_px, int height_px);

}  // namespace bakelight::reference
