// Transfer over the area around a vertex, in place of that at its point: of single vertices that stand out
// (outliers.h).
#pragma once

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
  std::vector<SeenVertex> seen;
};

// Empty if there is no point, or if all are buried.
AreaTransfer traceArea(const ShadowPass& pass, std::span<const SurfacePoint> points,
                       std::span<const formats::Triangle> sides_from_behind, const RowSizes& sizes,
                       ShadowPass::Workspace& work);

// By vertex.
using AreaTransfers = std::map<std::uint32_t, AreaTransfer>;

}  // namespace bakelight::transfer
