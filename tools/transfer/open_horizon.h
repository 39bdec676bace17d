// Transfer for those who leave out light from below the surface themselves.
#pragma once

#include "formats/triangle_mesh.h"
#include "tools/transfer/transfer.h"

namespace bakelight::transfer {

// Adds to matrices, or to visibility, that light from below each vertex's tangent plane passes. A radiance transfer texture
// is zero there; cutting the light off as well only loses what the edge of the cut has in further bands than are kept.
// Diffuse vectors stay. Cost: a product and a rotation a vertex, on all TBB threads.
void openHorizons(const formats::TriangleMesh& mesh, const TransferOptions& options, Transfer& transfer);

}  // namespace bakelight::transfer
