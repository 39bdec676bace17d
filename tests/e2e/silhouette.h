// Pixels where a rounding decides which surface is seen, so that two renderers may rightly differ.
#pragma once

#include <vector>

#include "formats/triangle_mesh.h"
#include "transport/camera.h"
#include "transport/cpu_renderer.h"

namespace bakelight::tests {

// Row-major, one entry a pixel. Marked are the pixels, with their eight neighbours, in which
// - a subsample and the next one see different surfaces, or surface and backdrop, or a depth jump;
// - an edge runs, visible or not, at which the mesh has split vertices (a crease): radiance jumps there from
// triangle to triangle.
std::vector<bool> silhouettePixels(const formats::TriangleMesh& mesh, const transport::CpuPicture& picture,
                                   const transport::OrbitCamera& camera, const transport::PictureGrid& grid);

}  // namespace bakelight::tests
