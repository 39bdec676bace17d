// Turning a mesh that was not modelled with +Y up.
#pragma once

#include "formats/triangle_mesh.h"
#include "formats/words.h"

namespace bakelight::simplify {

// Which axis of a mesh is up.
enum class UpAxis { kY, kMinusY, kZ, kMinusZ, kX, kMinusX };
inline constexpr formats::Word<UpAxis> kUpAxes[] = {{"y", UpAxis::kY}, {"-y", UpAxis::kMinusY},
                                                    {"z", UpAxis::kZ}, {"-z", UpAxis::kMinusZ},
                                                    {"x", UpAxis::kX}, {"-x", UpAxis::kMinusX}};

// Rotates positions and normals by quarter turns so that `up_axis` becomes +Y. Exact: coordinates change
// places and signs only.
void turnUpright(formats::TriangleMesh& mesh, UpAxis up_axis);

}  // namespace bakelight::simplify
