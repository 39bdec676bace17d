#include "tools/transfer/area_transfer.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace bakelight::transfer {

namespace {

constexpr int kSamplesPerArea = 16;

// Rows of several points, for their mean.
class RowSum {
 public:
  explicit RowSum(std::size_t size) : row_(size), sum_(size, 0.0) {}
  std::span<float> row() { return row_; }
  void add() {
    for (std::size_t i = 0; i < row_.size(); ++i) sum_[i] += row_[i];
  }
  std::vector<float> mean(std::size_t count) const {
    std::vector<float> mean;
    for (const double value : sum_) mean.push_back(static_cast<float>(value / static_cast<double>(count)));
    return mean;
  }

 private:
  std::vector<float> row_;
  std::vector<double> sum_;
};

std::vector<transport::SeenVertex> meanOf(std::vector<transport::SeenVertex> seen, std::size_t count) {
  std::stable_sort(
      seen.begin(), seen.end(),
      [](const transport::SeenVertex& a, const transport::SeenVertex& b) { return a.side < b.side; });
  std::vector<transport::SeenVertex> mean;
  for (const transport::SeenVertex& each : seen) {
    if (mean.empty() || mean.back().side != each.side) mean.push_back({each.side, 0});
    mean.back().weight += each.weight / static_cast<float>(count);
  }
  return mean;
}

}  // namespace

AreaTransfer traceArea(const ShadowPass& pass, std::span<const SurfacePoint> points,
                       std::span<const formats::Triangle> sides_from_behind, const RowSizes& sizes,
                       ShadowPass::Workspace& work) {
  AreaTransfer area;
  RowSum vector(sizes.vector), near_vector(sizes.near_vector), visibility(sizes.visibility);
  std::vector<transport::SeenVertex> seen;
  for (const SurfacePoint& point : points) {
    TracedPoint traced =
        pass.trace(point, sides_from_behind, {vector.row(), near_vector.row(), visibility.row()}, work);
    if (traced.buried) continue;
    area.vectors.insert(area.vectors.end(), vector.row().begin(), vector.row().end());
    vector.add(), near_vector.add(), visibility.add();
    seen.insert(seen.end(), traced.seen.begin(), traced.seen.end());
    area.points.push_back(point);
    area.blocked_rays.push_back(std::move(traced.blocked_rays));
  }
  const std::size_t count = area.points.size();
  if (count == 0) return area;
  area.vector = vector.mean(count);
  area.near_vector = near_vector.mean(count);
  area.visibility = visibility.mean(count);
  area.seen = meanOf(std::move(seen), count);
  return area;
}

Resampling resampleOutliers(const formats::TriangleMesh& mesh, const ShadowPass& pass,
                            std::span<const formats::Triangle> sides_from_behind,
                            std::span<const std::uint8_t> buried, float offset, double share,
                            const TransferRows& rows, transport::FormFactors& seen,
                            const LocalWorkspace& workspace) {
  const IncidentTriangles incident(mesh);
  const OutlierJudge judge(mesh, incident, rows.vectors, rows.sizes.vector, buried);
  std::vector<std::uint32_t> outliers = judge.outliers();
  Resampling result{outliers.size(), {}};
  const auto most =
      static_cast<std::size_t>(share / kSamplesPerArea * static_cast<double>(mesh.vertexCount()));
  outliers.resize(std::min(outliers.size(), most));

  std::vector<AreaTransfer> areas(outliers.size());
  tbb::parallel_for(std::size_t{0}, outliers.size(), [&](std::size_t i) {
    areas[i] = traceArea(pass, hatSamples(mesh, incident, outliers[i], offset, kSamplesPerArea),
                         sides_from_behind, rows.sizes, workspace());
  });
  // All are judged by what the points say, before any is replaced.
  for (std::size_t i = 0; i < outliers.size(); ++i) {
    const std::uint32_t v = outliers[i];
    if (!areas[i].points.empty() && judge.standsAlone(v, areas[i].vectors) &&
        judge.score(v, areas[i].vector) < judge.score(v, rows.of(v).vector))
      result.replaced.emplace(v, std::move(areas[i]));
  }
  for (auto& [v, area] : result.replaced) {
    const PointTransfer row = rows.of(v);
    std::copy(area.vector.begin(), area.vector.end(), row.vector.begin());
    std::copy(area.near_vector.begin(), area.near_vector.end(), row.near_vector.begin());
    std::copy(area.visibility.begin(), area.visibility.end(), row.visibility.begin());
    if (v < seen.rowCount()) seen.replace(v, std::move(area.seen));
  }
  return result;
}

}  // namespace bakelight::transfer
