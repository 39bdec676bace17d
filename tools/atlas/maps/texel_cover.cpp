#include "tools/atlas/maps/texel_cover.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "tools/atlas/maps/raster.h"

namespace bakelight::atlas {
namespace {

constexpr int kBandRows = 32;  // that one thread works on at a time

// Of a triangle: where in the plane, and weights of the second and third corner there.
struct CutPoint {
  Vec2 at, weights;
};

// A triangle cut by four lines has seven corners at most; rounding may add a few.
class Polygon {
 public:
  void clear() { size_ = 0; }
  void push(const CutPoint& point) {
    if (size_ < points_.size()) points_[size_++] = point;
  }
  std::size_t size() const { return size_; }
  const CutPoint& operator[](std::size_t i) const { return points_[i]; }

  // In the plane of the weights: ½ is the whole triangle. So it holds for flipped and for very thin ones.
  double area() const {
    double twice = 0;
    for (std::size_t i = 2; i < size_; ++i) {
      const Vec2 a = points_[i - 1].weights - points_[0].weights, b = points_[i].weights - points_[0].weights;
      twice += a.x() * b.y() - a.y() * b.x();
    }
    return twice / 2;
  }

 private:
  std::array<CutPoint, 16> points_;
  std::size_t size_ = 0;
};

// Sutherland & Hodgman 1974, both sides of the line at once, so that they share the points on it.
void cut(const Polygon& whole, int axis, double line, Polygon& below, Polygon& above) {
  below.clear(), above.clear();
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const CutPoint &a = whole[i], &b = whole[(i + 1) % whole.size()];
    const double from = a.at[axis] - line, to = b.at[axis] - line;
    if (from <= 0) below.push(a);
    if (from >= 0) above.push(a);
    if ((from < 0 && to > 0) || (from > 0 && to < 0)) {
      const double share = from / (from - to);
      CutPoint on_line = {a.at + share * (b.at - a.at), a.weights + share * (b.weights - a.weights)};
      on_line.at[axis] = line;
      below.push(on_line), above.push(on_line);
    }
  }
}

double surfaceArea(const formats::TriangleMesh& mesh, std::size_t triangle) {
  const formats::Triangle& t = mesh.triangles[triangle];
  const Vec3 a = transport::vec3(mesh.positions[t[0]]);
  return (transport::vec3(mesh.positions[t[1]]) - a).cross(transport::vec3(mesh.positions[t[2]]) - a).norm() /
         2;
}

// Some rows of the square. Triangles come chart by chart, so that a texel keeps sums of two charts only: the
// one that comes, and the best before.
class Band {
 public:
  Band(const Atlas& atlas, int resolution, const RowRange& rows, TexelCover& cover)
      : atlas_(atlas), resolution_(resolution), rows_(rows), cover_(cover) {
    const std::size_t texels = static_cast<std::size_t>(rows.end - rows.begin) * resolution;
    current_.assign(texels, {});
    best_.assign(texels, {});
  }

  void add(std::uint32_t triangle) {
    const TexelTriangle corners = texelTriangle(atlas_.mesh, triangle, resolution_);
    const int turn = orientationOf(corners[0], corners[1], corners[2]);
    if (turn == 0) return;
    claimCenters(triangle, corners);
    addAreas(triangle, corners);
  }

  void finish() {
    for (std::size_t k = 0; k < current_.size(); ++k) {
      keepBest(k);
      const std::size_t texel = static_cast<std::size_t>(rows_.begin) * resolution_ + k;
      const std::int32_t triangle = cover_.center_triangles[texel];
      cover_.charts[texel] =
          triangle < 0 ? best_[k].chart : static_cast<std::int32_t>(atlas_.triangle_charts[triangle]);
    }
  }

 private:
  struct ChartArea {
    std::int32_t chart = -1;
    double area = -1;
  };

  void claimCenters(std::uint32_t triangle, const TexelTriangle& corners) {
    centerSpans(corners, resolution_, spans_, rows_);
    for (const RowSpan& span : spans_)
      for (int i = span.begin; i < span.end; ++i) {
        std::int32_t& claim = cover_.center_triangles[static_cast<std::size_t>(span.row) * resolution_ + i];
        if (claim < 0 || static_cast<std::uint32_t>(claim) > triangle)
          claim = static_cast<std::int32_t>(triangle);
      }
  }

  void addAreas(std::uint32_t triangle, const TexelTriangle& corners) {
    Polygon whole, row, rest, left, right, unused;
    whole.push({corners[0], {0, 0}});
    whole.push({corners[1], {1, 0}});
    whole.push({corners[2], {0, 1}});
    const double full_area = surfaceArea(atlas_.mesh, triangle);
    touchedSpans(corners, resolution_, spans_, rows_);
    for (const RowSpan& span : spans_) {
      cut(whole, 1, span.row, unused, row);
      cut(row, 1, span.row + 1, rest, unused);
      for (int i = span.begin; i + 1 < span.end; ++i) {
        cut(rest, 0, i + 1, left, right);
        addArea(triangle, i, span.row, 2 * full_area * left.area());
        std::swap(rest, right);
      }
      addArea(triangle, span.end - 1, span.row, 2 * full_area * rest.area());
    }
  }

  void addArea(std::uint32_t triangle, int i, int j, double area) {
    const std::size_t k = static_cast<std::size_t>(j - rows_.begin) * resolution_ + i;
    const auto chart = static_cast<std::int32_t>(atlas_.triangle_charts[triangle]);
    cover_.areas[static_cast<std::size_t>(j) * resolution_ + i] += area;
    if (current_[k].chart != chart) {
      keepBest(k);
      current_[k] = {chart, 0};
    }
    current_[k].area += area;
  }

  void keepBest(std::size_t k) {
    if (current_[k].area > best_[k].area) best_[k] = current_[k];
  }

  const Atlas& atlas_;
  int resolution_;
  RowRange rows_;
  TexelCover& cover_;
  std::vector<ChartArea> current_, best_;
  std::vector<RowSpan> spans_;
};

// Triangles by the bands of rows that they reach, ordered by chart, then by number.
std::vector<std::vector<std::uint32_t>> trianglesByBand(const Atlas& atlas, int resolution) {
  std::vector<std::uint32_t> order(atlas.mesh.triangleCount());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return atlas.triangle_charts[a] < atlas.triangle_charts[b];
  });
  std::vector<std::vector<std::uint32_t>> bands((resolution + kBandRows - 1) / kBandRows);
  for (const std::uint32_t t : order) {
    const TexelTriangle corners = texelTriangle(atlas.mesh, t, resolution);
    const auto [bottom, top] = std::minmax({corners[0].y(), corners[1].y(), corners[2].y()});
    const auto first = static_cast<std::size_t>(bottom) / kBandRows;
    const auto last = std::min(static_cast<std::size_t>(top) / kBandRows, bands.size() - 1);
    for (std::size_t band = first; band <= last; ++band) bands[band].push_back(t);
  }
  return bands;
}

}  // namespace

TexelCover coverTexels(const Atlas& atlas, int resolution) {
  const std::size_t texels = static_cast<std::size_t>(resolution) * resolution;
  TexelCover cover{std::vector<double>(texels, 0), std::vector<std::int32_t>(texels, -1),
                   std::vector<std::int32_t>(texels, -1)};
  const auto bands = trianglesByBand(atlas, resolution);
  tbb::parallel_for(std::size_t{0}, bands.size(), [&](std::size_t b) {
    const int first = static_cast<int>(b) * kBandRows;
    Band band(atlas, resolution, {first, std::min(first + kBandRows, resolution)}, cover);
    for (const std::uint32_t triangle : bands[b]) band.add(triangle);
    band.finish();
  });
  return cover;
}

}  // namespace bakelight::atlas
