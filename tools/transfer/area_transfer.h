// Transfer over the area around a vertex, in place of that at its point: of single vertices that stand out
// (outliers.h).
#pragma once

#include <functional>
#include <map>
#include <span>
#include <vector>

#include "tools/transfer/outliers.h"
#include "tools/transfer/shadow_pass.h"

namespace bakelight::transfer {

// Lengths of a point's rows; 0 where there are none.
struct RowSizes {
  std::size_t vector = 0, near_vector = 0, visibility = 0;
};

// Means over points that stand for equal shares of an area.
struct AreaTransfer {
  std::vector<SurfacePoint> points;             // without those that are buried
  std::vector<std::vector<bool>> blocked_rays;  // of each, as in PointFigures
  std::vector<float> vector, near_vector, visibility;
  std::vector<float> vectors;  // of each
  std::vector<transport::SeenVertex> seen;
};

// Empty if there is no point, or if all are buried.
AreaTransfer traceArea(const ShadowPass& pass, std::span<const SurfacePoint> points,
                       std::span<const formats::Triangle> sides_from_behind, const RowSizes& sizes,
                       ShadowPass::Workspace& work);

// By vertex.
using AreaTransfers = std::map<std::uint32_t, AreaTransfer>;

// The calling thread's.
using LocalWorkspace = std::function<ShadowPass::Workspace&()>;

// Tables with a row a point; those whose rows have no length are empty.
struct TransferRows {
  std::span<float> vectors, near_vectors, visibility;
  RowSizes sizes;

  PointTransfer of(std::size_t point) const {
    return {vectors.subspan(point * sizes.vector, sizes.vector),
            near_vectors.subspan(point * sizes.near_vector, sizes.near_vector),
            visibility.subspan(point * sizes.visibility, sizes.visibility)};
  }
};

struct Resampling {
  std::size_t outlying = 0;  // vertices that stand out from their neighbours
  AreaTransfers replaced;    // those of them that stand out from their own area, too
};

// Puts the mean over their area in place of the rows, and of what they see, of vertices that stand out by
// point sampling alone. `rows` and `seen` (empty where hits are not recorded) are those of the vertices, and
// of one channel; `buried` has 1 for a vertex that is left out. Areas are `offset` off the surface, and take
// at most `share` of the rays that the vertices took; the worst outliers go first.
Resampling resampleOutliers(const formats::TriangleMesh& mesh, const ShadowPass& pass,
                            std::span<const formats::Triangle> sides_from_behind,
                            std::span<const std::uint8_t> buried, float offset, double share,
                            const TransferRows& rows, transport::FormFactors& seen,
                            const LocalWorkspace& workspace);

}  // namespace bakelight::transfer
