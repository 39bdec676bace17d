#include "tools/atlas/maps/geometry_maps.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "formats/error.h"
#include "tools/atlas/maps/border_walk.h"
#include "tools/atlas/maps/label_grid.h"
#include "tools/atlas/maps/nearest_border.h"
#include "tools/atlas/maps/raster.h"
#include "tools/atlas/maps/texel_cover.h"

namespace bakelight::atlas {
namespace {

using formats::TriangleMesh;
using transport::vec3;

constexpr std::size_t kMostTriangles = 1u << 24;

void checkInput(const TriangleMesh& mesh, const std::string& file) {
  if (mesh.triangleCount() > kMostTriangles)
    throw badInput({file, "", ""}, "it has " + std::to_string(mesh.triangleCount()) + " triangles",
                   "at most 16777216, which maps can number", "simplify it");
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t)
    for (const std::uint32_t v : mesh.triangles[t])
      for (const float x : mesh.texcoords[v])
        if (!(x >= 0 && x <= 1))
          throw badInput({file, "face " + std::to_string(t), ""}, "a texture coordinate lies outside 0–1",
                         "charts inside the square", "make an atlas with the tool atlas");
}

// A point of the surface, and which ways u and v grow there.
struct TexelPoint {
  int coverage;
  std::int32_t chart;
  std::uint32_t triangle;
  Vec3 weights;
  Vec3 u_way, v_way;
};

class Mapper {
 public:
  Mapper(const Atlas& atlas, const GeometryMapOptions& options, const std::string& file)
      : atlas_(atlas),
        mesh_(atlas.mesh),
        resolution_(options.resolution),
        cover_(coverTexels(atlas, options.resolution)),
        borders_(texelBorders(atlas.mesh, atlas.triangle_charts, options.resolution)) {
    // From the centre of a texel that a chart meets half a diagonal to the chart; as many as the border has
    // from there.
    const double reach = std::numbers::sqrt2 * (options.border + 0.5) + 1e-6;
    if (options.border > 0) prepareWalks(file);
    owners_ = options.border > 0 ? grownCharts(options.border) : cover_.charts;
    nearest_ = nearestBorders(borders_, resolution_, reach, owners_, cover_.center_triangles);
  }

  std::optional<TexelPoint> pointOf(int i, int j) const {
    const std::size_t texel = static_cast<std::size_t>(j) * resolution_ + i;
    const Vec2 center(i + 0.5, j + 0.5);
    if (cover_.center_triangles[texel] >= 0) return centerPoint(texel, center);
    if (nearest_[texel].border < 0) return std::nullopt;
    return cover_.charts[texel] >= 0 ? edgePoint(texel) : borderPoint(texel, center);
  }

  double area(int i, int j) const { return cover_.areas[static_cast<std::size_t>(j) * resolution_ + i]; }

 private:
  std::vector<std::int32_t> grownCharts(int steps) const {
    LabelGrid grid(resolution_);
    for (int j = 0; j < resolution_; ++j)
      for (int i = 0; i < resolution_; ++i)
        grid.at(i, j) = cover_.charts[static_cast<std::size_t>(j) * resolution_ + i];
    for (int step = 0; step < steps; ++step) grid.grow();
    std::vector<std::int32_t> charts(cover_.charts.size());
    for (int j = 0; j < resolution_; ++j)
      for (int i = 0; i < resolution_; ++i)
        charts[static_cast<std::size_t>(j) * resolution_ + i] = grid.at(i, j);
    return charts;
  }

  // The surface to walk on, and how long a texel of each chart is there.
  void prepareWalks(const std::string& file) {
    surface_ = surfaceOf(mesh_, file);
    surface_triangles_.assign(mesh_.triangleCount(), -1);
    std::vector<double> surface_areas(atlas_.chart_count, 0), plane_areas(atlas_.chart_count, 0);
    for (std::size_t s = 0; s < surface_.triangleCount(); ++s) {
      const std::uint32_t t = surface_.source_triangles[s], chart = atlas_.triangle_charts[t];
      surface_triangles_[t] = static_cast<std::int32_t>(s);
      const TexelTriangle plane = texelTriangle(mesh_, t, resolution_);
      surface_areas[chart] += surface_.areas[s];
      plane_areas[chart] += std::abs(((plane[1] - plane[0]).x() * (plane[2] - plane[0]).y() -
                                      (plane[1] - plane[0]).y() * (plane[2] - plane[0]).x()) /
                                     2);
    }
    texel_lengths_.assign(atlas_.chart_count, 0);
    for (std::size_t c = 0; c < texel_lengths_.size(); ++c)
      if (plane_areas[c] > 0) texel_lengths_[c] = std::sqrt(surface_areas[c] / plane_areas[c]);
  }

  TexelPoint centerPoint(std::size_t texel, const Vec2& center) const {
    const auto t = static_cast<std::uint32_t>(cover_.center_triangles[texel]);
    const TexelTriangle plane = texelTriangle(mesh_, t, resolution_);
    Vec3 weights;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 a = plane[(k + 1) % 3] - center, b = plane[(k + 2) % 3] - center;
      weights[k] = a.x() * b.y() - a.y() * b.x();
    }
    // Right to the sign before; rounding must not turn it.
    weights = (weights / weights.sum()).cwiseMax(0);
    return inTriangle(1, cover_.charts[texel], t, weights / weights.sum());
  }

  TexelPoint edgePoint(std::size_t texel) const {
    const auto& [b, along] = nearest_[texel];
    const TextureEdge& edge = borders_[b].edge;
    Vec3 weights = Vec3::Zero();
    weights[edge.edge] = 1 - along;
    weights[(edge.edge + 1) % 3] = along;
    return inTriangle(2, borders_[b].chart, edge.triangle, weights);
  }

  // Frame of the triangle's own map.
  TexelPoint inTriangle(int coverage, std::int32_t chart, std::uint32_t t, const Vec3& weights) const {
    const TexelTriangle plane = texelTriangle(mesh_, t, resolution_);
    const Vec3 a = corner(t, 0), ab = corner(t, 1) - a, ac = corner(t, 2) - a;
    const Vec2 p = plane[1] - plane[0], q = plane[2] - plane[0];
    const double turn = orientationOf(plane[0], plane[1], plane[2]);
    return {coverage, chart, t, weights, turn * (ab * q.y() - ac * p.y()), turn * (ac * p.x() - ab * q.x())};
  }

  std::optional<TexelPoint> borderPoint(std::size_t texel, const Vec2& center) const {
    // At a corner the walk starts a little beside it, so that it begins in one triangle.
    constexpr double kBesideCorner = 1e-6;
    const TexelBorder& border = borders_[nearest_[texel].border];
    const std::int32_t start = surface_triangles_[border.edge.triangle];
    if (start < 0) return std::nullopt;
    const double along = std::clamp(nearest_[texel].along, kBesideCorner, 1 - kBesideCorner);
    const Vec2 forward = (border.to - border.from) / border.length;
    const Vec2 way = center - (border.from + along * (border.to - border.from));
    const double length = way.norm();
    const double on = way.dot(forward) / length, out = std::max(way.dot(border.outward) / length, 1e-12);
    const double surface_length = length * texel_lengths_[border.chart];
    const std::optional<WalkEnd> end =
        walkAcross(surface_, static_cast<std::uint32_t>(start), border.edge.edge, along, on * surface_length,
                   out * surface_length);
    if (!end) return std::nullopt;
    // u and v as parts along the way and across it, both in the plane and on the surface.
    const Vec3 across_end = end->direction.cross(surface_.normals[end->triangle]);
    const Vec2 along_way = way / length, across_way = -out * forward + on * border.outward;
    return TexelPoint{3,
                      border.chart,
                      surface_.source_triangles[end->triangle],
                      end->weights,
                      along_way.x() * end->direction + across_way.x() * across_end,
                      along_way.y() * end->direction + across_way.y() * across_end};
  }

  Vec3 corner(std::uint32_t t, std::size_t k) const { return vec3(mesh_.positions[mesh_.triangles[t][k]]); }

  const Atlas& atlas_;
  const TriangleMesh& mesh_;
  int resolution_;
  TexelCover cover_;
  std::vector<TexelBorder> borders_;
  std::vector<std::int32_t> owners_;  // charts of texels, with their borders
  std::vector<BorderPoint> nearest_;
  // With a border only.
  Surface surface_;
  std::vector<std::int32_t> surface_triangles_;  // of the mesh's, −1: without area
  std::vector<double> texel_lengths_;            // of charts, in the surface's unit
};

Vec3 interpolated(const std::vector<formats::Float3>& values, const formats::Triangle& t,
                  const Vec3& weights) {
  return weights[0] * vec3(values[t[0]]) + weights[1] * vec3(values[t[1]]) + weights[2] * vec3(values[t[2]]);
}

// Nothing without a direction.
Vec3 normalAt(const TriangleMesh& mesh, const TexelPoint& point) {
  const formats::Triangle& t = mesh.triangles[point.triangle];
  if (!mesh.normals.empty()) {
    const Vec3 normal = interpolated(mesh.normals, t, point.weights);
    if (normal.norm() > 0) return normal.normalized();
  }
  const Vec3 a = vec3(mesh.positions[t[0]]);
  const Vec3 normal = (vec3(mesh.positions[t[1]]) - a).cross(vec3(mesh.positions[t[2]]) - a);
  return normal.norm() > 0 ? normal.normalized() : Vec3::UnitY();
}

// Order of the channels.
constexpr std::size_t kArea = 15;
const std::vector<std::string> kChannels = {"coverage",      "chart",      "triangle",   "barycentric.U",
                                            "barycentric.V", "position.X", "position.Y", "position.Z",
                                            "normal.X",      "normal.Y",   "normal.Z",   "tangent.X",
                                            "tangent.Y",     "tangent.Z",  "handedness", "area"};

void writePoint(const TriangleMesh& mesh, const TexelPoint& point, float* texel) {
  const Vec3 normal = normalAt(mesh, point);
  const Vec3 level = point.u_way.stableNormalized();
  Vec3 tangent = level - level.dot(normal) * normal;
  tangent = tangent.norm() > 1e-9 ? tangent.normalized() : normal.unitOrthogonal();
  const bool is_right_handed = normal.cross(tangent).dot(point.v_way) >= 0;

  *texel++ = static_cast<float>(point.coverage);
  *texel++ = static_cast<float>(point.chart);
  *texel++ = static_cast<float>(point.triangle);
  *texel++ = static_cast<float>(point.weights[1]);
  *texel++ = static_cast<float>(point.weights[2]);
  const Vec3 position = interpolated(mesh.positions, mesh.triangles[point.triangle], point.weights);
  for (const Vec3& vector : {position, normal, tangent})
    for (const double x : vector) *texel++ = static_cast<float>(x);
  *texel = is_right_handed ? 1 : -1;
}

}  // namespace

formats::Image geometryMaps(const Atlas& atlas, const GeometryMapOptions& options, const std::string& file) {
  checkInput(atlas.mesh, file);
  const int resolution = options.resolution;
  const Mapper mapper(atlas, options, file);
  formats::Image image(resolution, resolution, kChannels);
  tbb::parallel_for(0, resolution, [&](int j) {
    for (int i = 0; i < resolution; ++i) {
      float* texel = image.texel(i, resolution - 1 - j);
      texel[kArea] = static_cast<float>(mapper.area(i, j));
      if (const std::optional<TexelPoint> point = mapper.pointOf(i, j))
        writePoint(atlas.mesh, *point, texel);
      else
        texel[1] = texel[2] = -1;
    }
  });
  return image;
}

}  // namespace bakelight::atlas
