#include "tools/transfer/trace_phase.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "tools/transfer/outliers.h"
#include "transport/sh.h"

namespace bakelight::transfer {

namespace {

// A block of form factors is held in one piece. Small, so that no thread is left alone with the last one.
constexpr std::size_t kPointsPerBlock = 16;

TracedPoints tracePoints(const BakeSetup& setup, std::span<const SurfacePoint> points, const RowSizes& sizes,
                         bool keep_blocked, stage::Progress* progress) {
  const ShadowPass& pass = *setup.pass;
  TracedPoints traced;
  traced.sizes = sizes;
  traced.vectors.resize(points.size() * sizes.vector);
  traced.near_vectors.resize(points.size() * sizes.near_vector);
  traced.visibility.resize(points.size() * sizes.visibility);
  traced.figures.resize(points.size());
  traced.seen = transport::FormFactors(setup.memory.shares);
  if (keep_blocked) traced.blocked_rays.resize(points.size());

  const std::size_t block_count = (points.size() + kPointsPerBlock - 1) / kPointsPerBlock;
  std::vector<transport::FormFactors::Block> blocks(setup.interreflected() ? block_count : 0);
  const TransferRows rows = traced.rows();
  tbb::enumerable_thread_specific<ShadowPass::Workspace> workspaces(
      [&] { return ShadowPass::Workspace(pass); });
  tbb::parallel_for(std::size_t{0}, block_count, [&](std::size_t block) {
    ShadowPass::Workspace& work = workspaces.local();
    const std::size_t first = block * kPointsPerBlock, end = std::min(first + kPointsPerBlock, points.size());
    std::vector<std::vector<transport::SeenVertex>> seen;
    for (std::size_t p = first; p < end; ++p) {
      TracedPoint point = pass.trace(points[p], setup.sides_from_behind, rows.of(p), work);
      traced.figures[p] = point;
      if (keep_blocked) traced.blocked_rays[p] = std::move(point.blocked_rays);
      seen.push_back(std::move(point.seen));
    }
    if (!blocks.empty()) blocks[block] = traced.seen.packed(seen);
    if (progress != nullptr) progress->advance(end - first);
  });
  for (transport::FormFactors::Block& block : blocks) traced.seen.append(std::move(block));
  return traced;
}

template <class T>
void appendTo(std::vector<T>& values, std::vector<T>&& next) {
  values.insert(values.end(), std::make_move_iterator(next.begin()), std::make_move_iterator(next.end()));
}

std::size_t nearSize(const BakeSetup& setup) {
  return setup.sphere ? setup.coefficients : 0;
}

}  // namespace

void TracedPoints::append(TracedPoints&& next) {
  appendTo(vectors, std::move(next.vectors));
  appendTo(near_vectors, std::move(next.near_vectors));
  appendTo(visibility, std::move(next.visibility));
  appendTo(figures, std::move(next.figures));
  appendTo(blocked_rays, std::move(next.blocked_rays));
  seen.append(std::move(next.seen));
}

TracedPoints traceFronts(const BakeSetup& setup, PointRange range, stage::Progress& progress) {
  const std::size_t judged = transport::coefficientCount(kJudgedOrder);
  return tracePoints(setup, std::span(setup.fronts).subspan(range.first, range.size()),
                     {std::max(setup.coefficients, judged), nearSize(setup), setup.visibility_size},
                     setup.interreflected() && setup.needsMatrices(), &progress);
}

TracedPoints traceBacks(const BakeSetup& setup, std::span<const SurfacePoint> points) {
  return tracePoints(setup, points, {setup.coefficients, nearSize(setup), 0}, false, nullptr);
}

}  // namespace bakelight::transfer
