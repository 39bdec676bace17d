#include "patch/tiling.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include "formats/error.h"
#include "transport/camera.h"
#include "transport/texture_frames.h"
#include "transport/vector_types.h"

namespace bakelight::patch {
namespace {

using formats::Triangle;
using formats::TriangleMesh;
using transport::float3;
using transport::Vec3;
using transport::vec3;
using Vec2 = Eigen::Vector2d;

// Of places, in widths: nearer to an edge than this is on it, so that no slivers are cut off.
constexpr double kOnEdge = 1e-9;

// A point of the patch's surface that is being cut.
struct Corner {
  Vec3 at;      // x, y wherever the copy lies
  Vec3 normal;  // not unit between vertices
  Vec3 color;
  std::int64_t vertex = -1;  // of the patch's mesh; −1: made by a cut
};

Corner between(const Corner& a, const Corner& b, double share) {
  return {a.at + share * (b.at - a.at), a.normal + share * (b.normal - a.normal),
          a.color + share * (b.color - a.color)};
}

// A triangle of the surface, and how places of the patch lie on it.
class Facet {
 public:
  Facet(const TriangleMesh& surface, const Triangle& corners, const Tiling& tiling) : width_(tiling.width) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& uv = surface.texcoords[corners[i]];
      places_[i] = tiling.repeats * Vec2(uv[0], uv[1]);
      positions_[i] = vec3(surface.positions[corners[i]]);
      normals_[i] = vec3(surface.normals[corners[i]]).normalized();
    }
    const Vec2 first = places_[1] - places_[0], second = places_[2] - places_[0];
    determinant_ = first.x() * second.y() - first.y() * second.x();
    if (isBare()) return;
    weights_from_place_ << second.y(), -second.x(), -first.y(), first.x();
    weights_from_place_ /= determinant_;
    along_ = slopesOf(positions_);
    bend_ = slopesOf(normals_);
  }

  bool isBare() const {
    return !(std::abs(determinant_) > 1e-14) ||
           !((positions_[1] - positions_[0]).cross(positions_[2] - positions_[0]).norm() > 0);
  }
  bool isMirrored() const { return determinant_ < 0; }
  double area() const { return std::abs(determinant_) / 2; }  // in widths²

  Vec2 low() const { return places_[0].cwiseMin(places_[1]).cwiseMin(places_[2]); }
  Vec2 high() const { return places_[0].cwiseMax(places_[1]).cwiseMax(places_[2]); }

  // What of the polygon lies on this facet; nothing where it only touches it. Of two facets at an edge one keeps
  // what stands on it.
  void cut(std::vector<Corner>& polygon, std::vector<Corner>& spare) const {
    for (std::size_t i = 0; i < 3 && !polygon.empty(); ++i) {
      const std::size_t next = (i + 1) % 3;
      const Vec2 from = isMirrored() ? places_[next] : places_[i],
                 to = isMirrored() ? places_[i] : places_[next];
      const Vec2 edge = (to - from).normalized();
      const bool owns = edge.y() > 0 || (edge.y() == 0 && edge.x() > 0);
      const auto inside = [&](const Corner& corner) {
        const Vec2 offset = corner.at.head<2>() - from;
        const double distance = edge.x() * offset.y() - edge.y() * offset.x();
        return std::abs(distance) <= kOnEdge ? 0.0 : distance;
      };
      spare.clear();
      bool any_inside = false;
      for (std::size_t k = 0; k < polygon.size(); ++k) {
        const Corner &here = polygon[k], &there = polygon[(k + 1) % polygon.size()];
        const double a = inside(here), b = inside(there);
        any_inside = any_inside || a > 0;
        if (a >= 0) spare.push_back(here);
        // From the same end whichever side asks.
        if (a > 0 && b < 0) spare.push_back(between(here, there, a / (a - b)));
        if (a < 0 && b > 0) spare.push_back(between(there, here, b / (b - a)));
      }
      const bool stands_on_edge = !any_inside && owns && spare.size() == polygon.size();
      if (!any_inside && !stands_on_edge) spare.clear();
      polygon.swap(spare);
    }
    if (polygon.size() < 3) polygon.clear();
  }

  struct Placed {
    Float3 position, normal;
  };
  Placed placed(const Corner& corner) const {
    const Vec2 w = weights_from_place_ * (corner.at.head<2>() - places_[0]);
    const auto mean = [&](const std::array<Vec3, 3>& of) {
      return Vec3(of[0] + w[0] * (of[1] - of[0]) + w[1] * (of[2] - of[0]));
    };
    const Vec3 sum = mean(normals_);
    const Vec3 up = sum.norm() > 0 ? Vec3(sum.normalized()) : Vec3(normals_[0]);
    const double height = width_ * corner.at.z();
    // Derivatives of the map, on the smooth surface that the normals are of; the normal by its inverse transpose.
    Eigen::Matrix3d map;
    for (int axis = 0; axis < 2; ++axis) {
      const Vec3 slope = along_.col(axis) + height * bend_.col(axis);
      map.col(axis) = slope - slope.dot(up) * up;
    }
    map.col(2) = width_ * up;
    Eigen::Matrix3d cofactors;
    cofactors << map.col(1).cross(map.col(2)), map.col(2).cross(map.col(0)), map.col(0).cross(map.col(1));
    Vec3 normal = cofactors * corner.normal;
    if (isMirrored()) normal = -normal;
    return {float3(mean(positions_) + height * up),
            float3(normal.norm() > 0 ? Vec3(normal.normalized()) : up)};
  }

 private:
  // Derivatives by place of what is linear between the corners.
  Eigen::Matrix<double, 3, 2> slopesOf(const std::array<Vec3, 3>& values) const {
    Eigen::Matrix<double, 3, 2> edges;
    edges << values[1] - values[0], values[2] - values[0];
    return edges * weights_from_place_;
  }

  double width_;
  std::array<Vec2, 3> places_;
  std::array<Vec3, 3> positions_, normals_;
  double determinant_ = 0;
  Eigen::Matrix2d weights_from_place_;
  Eigen::Matrix<double, 3, 2> along_, bend_;
};

// The patch's triangles by where they are.
class TriangleGrid {
 public:
  explicit TriangleGrid(const TriangleMesh& mesh) {
    for (const Triangle& t : mesh.triangles) {
      Box box{placeOf(mesh, t[0]), placeOf(mesh, t[0])};
      for (const std::uint32_t v : t)
        box.low = box.low.cwiseMin(placeOf(mesh, v)), box.high = box.high.cwiseMax(placeOf(mesh, v));
      boxes_.push_back(box);
    }
    all_ = boxes_.empty() ? Box{Vec2(0, 0), Vec2(0, 0)} : boxes_.front();
    for (const Box& box : boxes_)
      all_.low = all_.low.cwiseMin(box.low), all_.high = all_.high.cwiseMax(box.high);
    for (std::uint32_t t = 0; t < boxes_.size(); ++t)
      forCells(boxes_[t], [&](int cell) { cells_[static_cast<std::size_t>(cell)].push_back(t); });
  }

  const Vec2& low() const { return all_.low; }
  const Vec2& high() const { return all_.high; }

  // Each triangle whose box meets this one, once.
  template <class Visit>
  void visit(const Vec2& low, const Vec2& high, const Visit& visit) const {
    const Box asked{low, high};
    forCells(asked, [&](int cell) {
      for (const std::uint32_t t : cells_[static_cast<std::size_t>(cell)]) {
        const Vec2 first = boxes_[t].low.cwiseMax(low), last = boxes_[t].high.cwiseMin(high);
        if ((first.array() <= last.array()).all() && cellOf(first) == cell) visit(t);
      }
    });
  }

 private:
  struct Box {
    Vec2 low, high;
  };
  static constexpr int kSide = 64;

  static Vec2 placeOf(const TriangleMesh& mesh, std::uint32_t v) {
    return {mesh.positions[v][0], mesh.positions[v][1]};
  }
  int columnOf(double x, int axis) const {
    const double extent = all_.high[axis] - all_.low[axis];
    return extent > 0
               ? std::clamp(static_cast<int>(std::floor(kSide * (x - all_.low[axis]) / extent)), 0, kSide - 1)
               : 0;
  }
  int cellOf(const Vec2& at) const { return columnOf(at.y(), 1) * kSide + columnOf(at.x(), 0); }
  template <class Visit>
  void forCells(const Box& box, const Visit& visit) const {
    for (int y = columnOf(box.low.y(), 1); y <= columnOf(box.high.y(), 1); ++y)
      for (int x = columnOf(box.low.x(), 0); x <= columnOf(box.high.x(), 0); ++x) visit(y * kSide + x);
  }

  std::vector<Box> boxes_;
  Box all_;
  std::vector<std::vector<std::uint32_t>> cells_{static_cast<std::size_t>(kSide * kSide)};
};

class Tiler {
 public:
  explicit Tiler(const PatchGeometry& patch) : patch_(patch), grid_(patch.mesh) {}

  void lay(const Facet& facet) {
    const Vec2 low = facet.low(), high = facet.high();
    const auto first = [&](int axis, double period) { return (low[axis] - grid_.high()[axis]) / period; };
    const auto last = [&](int axis, double period) { return (high[axis] - grid_.low()[axis]) / period; };
    for (double j = std::floor(first(1, patch_.period_y)); j <= std::ceil(last(1, patch_.period_y)); ++j)
      for (double i = std::floor(first(0, patch_.period_x)); i <= std::ceil(last(0, patch_.period_x)); ++i) {
        const Vec2 shift(i * patch_.period_x, j * patch_.period_y);
        made_.clear();
        grid_.visit(low - shift, high - shift, [&](std::uint32_t t) { layTriangle(facet, t, shift); });
      }
  }

  TriangleMesh take() { return std::move(mesh_); }

 private:
  void layTriangle(const Facet& facet, std::uint32_t t, const Vec2& shift) {
    polygon_.clear();
    for (const std::uint32_t v : patch_.mesh.triangles[t]) {
      const Vec3 color = vec3(patch_.mesh.colors.empty() ? Float3{1, 1, 1} : patch_.mesh.colors[v]);
      polygon_.push_back({vec3(patch_.mesh.positions[v]) + Vec3(shift.x(), shift.y(), 0),
                          vec3(patch_.mesh.normals[v]), color.cwiseProduct(vec3(patch_.albedo)), v});
    }
    facet.cut(polygon_, spare_);
    if (polygon_.empty()) return;
    numbers_.clear();
    for (const Corner& corner : polygon_) numbers_.push_back(vertexOf(facet, corner));
    for (std::size_t k = 2; k < numbers_.size(); ++k) {
      const Vec3 area = (polygon_[k - 1].at - polygon_[0].at).cross(polygon_[k].at - polygon_[0].at);
      if (!(area.norm() > 0)) continue;
      if (facet.isMirrored())
        mesh_.triangles.push_back({numbers_[0], numbers_[k], numbers_[k - 1]});
      else
        mesh_.triangles.push_back({numbers_[0], numbers_[k - 1], numbers_[k]});
    }
  }

  std::uint32_t vertexOf(const Facet& facet, const Corner& corner) {
    const auto next = static_cast<std::uint32_t>(mesh_.positions.size());
    if (corner.vertex >= 0) {
      const auto [found, is_new] = made_.try_emplace(static_cast<std::uint32_t>(corner.vertex), next);
      if (!is_new) return found->second;
    }
    const auto [position, normal] = facet.placed(corner);
    mesh_.positions.push_back(position);
    mesh_.normals.push_back(normal);
    mesh_.texcoords.push_back({static_cast<float>(corner.at.x()), static_cast<float>(corner.at.y())});
    mesh_.colors.push_back(float3(corner.color));
    return next;
  }

  const PatchGeometry& patch_;
  TriangleGrid grid_;
  TriangleMesh mesh_;
  std::unordered_map<std::uint32_t, std::uint32_t> made_;  // vertices of this copy on this facet
  std::vector<Corner> polygon_, spare_;
  std::vector<std::uint32_t> numbers_;
};

// Edges between charts whose places differ by something that is no period.
std::size_t brokenEdges(const PatchGeometry& patch, const TriangleMesh& surface, double repeats) {
  using Place = std::array<std::int64_t, 3>;
  struct End {
    Place at;
    Vec2 place;
  };
  const double size = transport::boundingSphere(surface).radius;
  const auto endOf = [&](std::uint32_t v) {
    End end{{}, repeats * Vec2(surface.texcoords[v][0], surface.texcoords[v][1])};
    for (std::size_t c = 0; c < 3; ++c)
      end.at[c] = static_cast<std::int64_t>(std::round(surface.positions[v][c] / (1e-5 * size)));
    return end;
  };
  const auto differs = [](double offset, double period) {
    return std::abs(offset / period - std::round(offset / period)) > 1e-3;
  };
  struct Edge {
    std::array<Vec2, 2> places;
    bool broken = false;
  };
  std::map<std::array<Place, 2>, Edge> edges;
  for (const Triangle& t : surface.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      std::array<End, 2> ends = {endOf(t[i]), endOf(t[(i + 1) % 3])};
      if (ends[1].at < ends[0].at) std::swap(ends[0], ends[1]);
      const auto [found, is_new] =
          edges.try_emplace({ends[0].at, ends[1].at}, Edge{{ends[0].place, ends[1].place}});
      if (is_new) continue;
      for (std::size_t k = 0; k < 2; ++k) {
        const Vec2 offset = ends[k].place - found->second.places[k];
        if (differs(offset.x(), patch.period_x) || differs(offset.y(), patch.period_y))
          found->second.broken = true;
      }
    }
  return static_cast<std::size_t>(
      std::count_if(edges.begin(), edges.end(), [](const auto& edge) { return edge.second.broken; }));
}

// Without what cuts add.
double expectedTriangles(const PatchGeometry& patch, const std::vector<Facet>& facets) {
  double area = 0;
  for (const Facet& facet : facets) area += facet.area();
  return area / (patch.period_x * patch.period_y) * static_cast<double>(patch.mesh.triangleCount());
}

}  // namespace

Tiling tilingOf(const TriangleMesh& surface, double width) {
  const transport::PatchRepeats repeats = transport::patchRepeats(surface, width);
  return {repeats.repeats, repeats.width};
}

TiledSurface tiled(const PatchGeometry& patch, const TriangleMesh& surface, const Tiling& tiling,
                   const std::string& file) {
  if (surface.texcoords.size() != surface.vertexCount())
    throw badInput({file, "", ""}, "it has no texture coordinates for a patch to lie by", "one a vertex",
                   "use the mesh that atlas wrote, or one with texture coordinates of its own");
  if (surface.normals.size() != surface.vertexCount())
    throw badInput({file, "", ""}, "it has no normals for a patch to stand along", "one a vertex",
                   "run the mesh through simplify, which makes them");
  TiledSurface result;
  std::vector<Facet> facets;
  for (const Triangle& triangle : surface.triangles) {
    const Facet facet(surface, triangle, tiling);
    if (facet.isBare())
      ++result.bare_triangles;
    else
      facets.push_back(facet);
  }
  if (const double expected = expectedTriangles(patch, facets); !(expected < kMostTiledTriangles))
    throw badInput({file, "", ""},
                   fmt::format("the patch of {} triangles, repeated over it, has about {:.3g}",
                               patch.mesh.triangleCount(), expected),
                   fmt::format("at most {}", kMostTiledTriangles),
                   "make the patch wider, or its picture or mesh coarser");
  Tiler tiler(patch);
  for (const Facet& facet : facets) tiler.lay(facet);
  result.mesh = tiler.take();
  result.broken_edges = brokenEdges(patch, surface, tiling.repeats);
  return result;
}

}  // namespace bakelight::patch
