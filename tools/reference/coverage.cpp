#include "tools/reference/coverage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace bakelight::reference {

using transport::Vec3;

std::vector<std::uint8_t> possiblyCovered(const formats::TriangleMesh& mesh,
                                          const transport::OrbitCamera& camera, int width_px, int height_px) {
  const auto width = static_cast<std::size_t>(width_px), height = static_cast<std::size_t>(height_px);
  const Eigen::Matrix4d view = camera.viewFromWorld();
  const double half_height = height_px / 2.0, half_width = width_px / 2.0;
  const double focal_px = half_height / std::tan(camera.field_of_view_deg * std::numbers::pi / 360);
  const double nearest = 1e-6 * camera.distance;

  // Pixel coordinates of each vertex; NaN for one that is not in front of the eye.
  std::vector<std::array<double, 2>> projected;
  for (const formats::Float3& position : mesh.positions) {
    const Vec3 p = view.topLeftCorner<3, 3>() * transport::vec3(position) + view.topRightCorner<3, 1>();
    const double scale = -p.z() > nearest ? focal_px / -p.z() : std::numeric_limits<double>::quiet_NaN();
    projected.push_back({half_width + scale * p.x(), half_height - scale * p.y()});
  }

  std::vector<std::uint8_t> covered(width * height, 0);
  for (const auto& [a, b, c] : mesh.triangles) {
    std::array<std::array<std::size_t, 2>, 2> range{};  // of columns and rows
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const auto [low, high] = std::minmax({projected[a][axis], projected[b][axis], projected[c][axis]});
      if (std::isnan(projected[a][axis] + projected[b][axis] + projected[c][axis])) {
        std::fill(covered.begin(), covered.end(), std::uint8_t{1});
        return covered;
      }
      const double end = axis == 0 ? width_px : height_px;
      range[axis] = {static_cast<std::size_t>(std::clamp(std::floor(low) - 1, 0.0, end)),
                     static_cast<std::size_t>(std::clamp(std::floor(high) + 2, 0.0, end))};
    }
    for (std::size_t y = range[1][0]; y < range[1][1]; ++y)
      for (std::size_t x = range[0][0]; x < range[0][1]; ++x) covered[y * width + x] = 1;
  }
  return covered;
}

}  // namespace bakelight::reference
