#include "tests/e2e/silhouette.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <Eigen/Geometry>
#include <map>
#include <numbers>
#include <set>
#include <utility>

namespace bakelight::tests {
namespace {

using transport::Vec3;

using Segment = std::pair<formats::Float3, formats::Float3>;

// Edges whose two triangles name different vertices at the same positions.
std::vector<Segment> creases(const formats::TriangleMesh& mesh) {
  std::map<Segment, std::set<std::array<std::uint32_t, 2>>> vertices_at;
  for (const auto& triangle : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t a = triangle[k], b = triangle[(k + 1) % 3];
      if (mesh.positions[b] < mesh.positions[a]) std::swap(a, b);
      vertices_at[{mesh.positions[a], mesh.positions[b]}].insert({a, b});
    }
  std::vector<Segment> segments;
  for (const auto& [segment, vertices] : vertices_at)
    if (vertices.size() > 1) segments.push_back(segment);
  return segments;
}

class SilhouetteFinder {
 public:
  SilhouetteFinder(const formats::TriangleMesh& mesh, const transport::CpuPicture& picture,
                   const transport::OrbitCamera& camera, const transport::PictureGrid& grid)
      : mesh_(mesh),
        hits_(picture.hits),
        camera_(camera),
        grid_(grid),
        columns_(grid.width_px * grid.supersampling),
        rows_(grid.height_px * grid.supersampling),
        footprint_rad_(camera.field_of_view_deg * std::numbers::pi / 180 / rows_),
        marked_(static_cast<std::size_t>(grid.width_px) * grid.height_px, false) {}

  std::vector<bool> pixels() && {
    for (int row = 0; row < rows_; ++row)
      for (int column = 0; column < columns_; ++column) {
        if (column + 1 < columns_ && edgeBetween(column, row, column + 1, row)) markSubsample(column, row);
        if (row + 1 < rows_ && edgeBetween(column, row, column, row + 1)) markSubsample(column, row);
      }
    for (const Segment& crease : creases(mesh_)) markSegment(crease);
    return std::move(marked_);
  }

 private:
  void markSubsample(int column, int row) {
    markAround(column / grid_.supersampling, row / grid_.supersampling);
  }

  void markAround(int x, int y) {
    for (int j = std::max(y - 1, 0); j <= std::min(y + 1, grid_.height_px - 1); ++j)
      for (int i = std::max(x - 1, 0); i <= std::min(x + 1, grid_.width_px - 1); ++i)
        marked_[static_cast<std::size_t>(j) * grid_.width_px + i] = true;
  }

  // In steps of half a pixel at most; what lies behind the camera is left.
  void markSegment(const Segment& segment) {
    const double focal_px =
        grid_.height_px / 2.0 / std::tan(camera_.field_of_view_deg * std::numbers::pi / 360);
    const Eigen::Affine3d view_from_world(camera_.viewFromWorld());
    const Vec3 a = view_from_world * transport::vec3(segment.first);
    const Vec3 b = view_from_world * transport::vec3(segment.second);
    const double nearest = -std::max(a.z(), b.z());
    if (nearest <= 0) return;
    const int steps = 1 + static_cast<int>(2 * focal_px * (b - a).norm() / nearest);
    for (int step = 0; step <= steps; ++step) {
      const Vec3 point = a + (b - a) * (static_cast<double>(step) / steps);
      const double x = grid_.width_px / 2.0 - focal_px * point.x() / point.z();
      const double y = grid_.height_px / 2.0 + focal_px * point.y() / point.z();
      if (std::abs(x) < 1e6 && std::abs(y) < 1e6) markAround(static_cast<int>(x), static_cast<int>(y));
    }
  }

  const transport::SubsampleHit& hit(int column, int row) const {
    return hits_[static_cast<std::size_t>(row) * columns_ + column];
  }
  Vec3 direction(int column, int row) const {
    return camera_.directionThrough(column + 0.5, row + 0.5, columns_, rows_);
  }
  Vec3 normal(std::uint32_t triangle) const {
    const auto [a, b, c] = mesh_.triangles[triangle];
    const Vec3 origin = transport::vec3(mesh_.positions[a]);
    return (transport::vec3(mesh_.positions[b]) - origin)
        .cross(transport::vec3(mesh_.positions[c]) - origin)
        .normalized();
  }

  // A surface that goes on stays near its own tangent plane from one subsample to the next; a jump leaves the
  // plane of one of the two, or both are seen so flatly that the depth leaps.
  bool edgeBetween(int column_a, int row_a, int column_b, int row_b) const {
    constexpr double kOffPlaneFootprints = 1, kStepFootprints = 12;
    const auto &a = hit(column_a, row_a), &b = hit(column_b, row_b);
    if (a.valid() != b.valid()) return true;
    if (!a.valid() || a.triangle == b.triangle) return false;
    const Vec3 step = b.distance * direction(column_b, row_b) - a.distance * direction(column_a, row_a);
    const double footprint = footprint_rad_ * std::min(a.distance, b.distance);
    const double off_plane =
        std::max(std::abs(step.dot(normal(a.triangle))), std::abs(step.dot(normal(b.triangle))));
    return off_plane > kOffPlaneFootprints * footprint || step.norm() > kStepFootprints * footprint;
  }

  const formats::TriangleMesh& mesh_;
  const std::vector<transport::SubsampleHit>& hits_;
  const transport::OrbitCamera camera_;
  const transport::PictureGrid grid_;
  const int columns_, rows_;    // of subsamples
  const double footprint_rad_;  // angle between subsamples
  std::vector<bool> marked_;
};

}  // namespace

std::vector<bool> silhouettePixels(const formats::TriangleMesh& mesh, const transport::CpuPicture& picture,
                                   const transport::OrbitCamera& camera, const transport::PictureGrid& grid) {
  return SilhouetteFinder(mesh, picture, camera, grid).pixels();
}

}  // namespace bakelight::tests
