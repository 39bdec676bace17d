// The first phase of a bake: what the rays of a range of points find. Ranges that follow each other give,
// appended, the very bytes of the whole.
#pragma once

#include <vector>

#include "tools/stage/progress.h"
#include "tools/transfer/area_transfer.h"
#include "tools/transfer/bake_setup.h"

namespace bakelight::transfer {

struct PointRange {
  std::size_t first = 0, end = 0;
  std::size_t size() const { return end - first; }
};

// Rows of points in their order. Of one channel: nothing has bounced yet.
struct TracedPoints {
  RowSizes sizes;
  std::vector<float> vectors, near_vectors, visibility;
  std::vector<PointFigures> figures;
  // Interreflected only: the form factors, as sides of vertices. The same query tells them and what a vector
  // lets pass of rays that graze an edge, so both are found at once.
  transport::FormFactors seen;
  std::vector<std::vector<bool>> blocked_rays;  // interreflected matrices only

  TransferRows rows() { return {vectors, near_vectors, visibility, sizes}; }
  void append(TracedPoints&& next);
};

// Fronts of the vertices `range`. Vectors have at least the bands that outliers are judged by. `progress`
// advances by one per point.
TracedPoints traceFronts(const BakeSetup& setup, PointRange range, stage::Progress& progress);
// Any points; vectors of the bake's order, and no visibility.
TracedPoints traceBacks(const BakeSetup& setup, std::span<const SurfacePoint> points);

}  // namespace bakelight::transfer
