#include "tools/atlas/maps/nearest_border.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/atlas/maps/raster.h"

namespace bakelight::atlas {
namespace {

constexpr int kBandRows = 32;  // that one thread works on at a time

struct Candidate {
  double squared_distance = std::numeric_limits<double>::infinity();
  double outward = 0;  // of the way from the border to the centre
  BorderPoint point;
};

Candidate candidateOf(const TexelBorder& border, std::int32_t index, const Vec2& center) {
  const Vec2 way = border.to - border.from;
  const double along = std::clamp((center - border.from).dot(way) / way.squaredNorm(), 0.0, 1.0);
  // The corners themselves, not what rounding makes of them: edges that meet there are equally near.
  const Vec2 nearest = along == 0 ? border.from : along == 1 ? border.to : Vec2(border.from + along * way);
  return {(center - nearest).squaredNorm(), (center - nearest).dot(border.outward), {index, along}};
}

bool isBetter(const Candidate& a, const Candidate& b) {
  return a.squared_distance != b.squared_distance ? a.squared_distance < b.squared_distance
                                                  : a.outward > b.outward;
}

// Columns whose centres may be within reach in the row with centres at height y.
RowRange columnsWithin(const TexelBorder& border, double reach, double y, int resolution) {
  const double rise = border.to.y() - border.from.y();
  double begin = 0, end = 1;
  if (rise != 0) {
    const auto [enter, leave] =
        std::minmax({(y - reach - border.from.y()) / rise, (y + reach - border.from.y()) / rise});
    begin = std::clamp(enter, 0.0, 1.0), end = std::clamp(leave, 0.0, 1.0);
  }
  const double a = border.from.x() + begin * (border.to.x() - border.from.x());
  const double b = border.from.x() + end * (border.to.x() - border.from.x());
  return {std::max(static_cast<int>(std::floor(std::min(a, b) - reach - 0.5)), 0),
          std::min(static_cast<int>(std::ceil(std::max(a, b) + reach + 0.5)), resolution)};
}

}  // namespace

std::vector<TexelBorder> texelBorders(const formats::TriangleMesh& mesh,
                                      std::span<const std::uint32_t> triangle_charts, int resolution) {
  std::vector<TexelBorder> borders;
  for (const TextureEdge& edge : borderEdges(mesh)) {
    const TexelTriangle corners = texelTriangle(mesh, edge.triangle, resolution);
    const Vec2 &from = corners[edge.edge], &to = corners[(edge.edge + 1u) % 3];
    const int turn = orientationOf(corners[0], corners[1], corners[2]);
    if (turn == 0) continue;
    const Vec2 direction = (to - from).normalized();
    borders.push_back({edge, static_cast<std::int32_t>(triangle_charts[edge.triangle]), from, to,
                       turn * Vec2(direction.y(), -direction.x()), (to - from).norm()});
  }
  return borders;
}

std::vector<BorderPoint> nearestBorders(std::span<const TexelBorder> borders, int resolution, double reach,
                                        std::span<const std::int32_t> charts,
                                        std::span<const std::int32_t> center_triangles) {
  std::vector<BorderPoint> nearest(charts.size());
  const int bands = (resolution + kBandRows - 1) / kBandRows;
  tbb::parallel_for(0, bands, [&](int band) {
    const int begin = band * kBandRows, end = std::min(begin + kBandRows, resolution);
    const std::size_t first_texel = static_cast<std::size_t>(begin) * resolution;
    std::vector<Candidate> best(static_cast<std::size_t>(end - begin) * resolution);
    for (std::size_t b = 0; b < borders.size(); ++b) {
      const TexelBorder& border = borders[b];
      const auto [low, high] = std::minmax({border.from.y(), border.to.y()});
      const int first = std::max(static_cast<int>(std::floor(low - reach - 0.5)), begin);
      const int last = std::min(static_cast<int>(std::ceil(high + reach + 0.5)), end);
      for (int j = first; j < last; ++j) {
        const RowRange columns = columnsWithin(border, reach, j + 0.5, resolution);
        for (int i = columns.begin; i < columns.end; ++i) {
          const std::size_t texel = static_cast<std::size_t>(j) * resolution + i;
          if (charts[texel] != border.chart || center_triangles[texel] >= 0) continue;
          const Candidate candidate = candidateOf(border, static_cast<std::int32_t>(b), {i + 0.5, j + 0.5});
          if (isBetter(candidate, best[texel - first_texel])) best[texel - first_texel] = candidate;
        }
      }
    }
    for (std::size_t k = 0; k < best.size(); ++k)
      if (best[k].squared_distance <= reach * reach) nearest[first_texel + k] = best[k].point;
  });
  return nearest;
}

}  // namespace bakelight::atlas
