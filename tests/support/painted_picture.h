// Pictures of meshes by their vertex colours, to look at.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "formats/image.h"
#include "formats/triangle_mesh.h"
#include "transport/vector_types.h"

namespace bakelight::tests {

// Seen from far away, the camera turned by `yaw_deg` around +Y from +Z; colours under a lamp at the camera. `zoom`
// enlarges the middle of the picture.
inline formats::Image paintedPicture(const formats::TriangleMesh& mesh, int side, double yaw_deg,
                                     double zoom = 1) {
  using transport::Vec3;
  const double yaw = yaw_deg * std::numbers::pi / 180;
  const auto seen = [&](const formats::Float3& p) {
    return Vec3(std::cos(yaw) * p[0] - std::sin(yaw) * p[2], p[1],
                std::sin(yaw) * p[0] + std::cos(yaw) * p[2]);
  };
  Vec3 least = Vec3::Constant(std::numeric_limits<double>::max()), most = -least;
  for (const formats::Float3& p : mesh.positions)
    least = least.cwiseMin(seen(p)), most = most.cwiseMax(seen(p));
  const Vec3 middle = 0.5 * (least + most);
  const double scale = zoom * 0.97 * side / std::max(most.x() - least.x(), most.y() - least.y());
  formats::Image image(side, side, {"R", "G", "B"});
  std::fill(image.values.begin(), image.values.end(), 1.0f);
  std::vector<double> depths(static_cast<std::size_t>(side) * side, -std::numeric_limits<double>::max());
  for (const formats::Triangle& t : mesh.triangles) {
    std::array<Vec3, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 p = seen(mesh.positions[t[k]]) - middle;
      corners[k] = {0.5 * side + scale * p.x(), 0.5 * side - scale * p.y(), p.z()};
    }
    const auto area = [](const Vec3& a, const Vec3& b, const Vec3& c) {
      return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    };
    const double whole = area(corners[0], corners[1], corners[2]);
    if (whole >= 0) continue;  // turned away
    const auto [left, right] = std::minmax({corners[0].x(), corners[1].x(), corners[2].x()});
    const auto [top, bottom] = std::minmax({corners[0].y(), corners[1].y(), corners[2].y()});
    for (int y = std::max(0, static_cast<int>(top)); y <= std::min(side - 1, static_cast<int>(bottom)); ++y)
      for (int x = std::max(0, static_cast<int>(left)); x <= std::min(side - 1, static_cast<int>(right));
           ++x) {
        const Vec3 at(x + 0.5, y + 0.5, 0);
        const std::array<double, 3> weights = {area(corners[1], corners[2], at) / whole,
                                               area(corners[2], corners[0], at) / whole,
                                               area(corners[0], corners[1], at) / whole};
        if (*std::min_element(weights.begin(), weights.end()) < 0) continue;
        double depth = 0, facing = 0;
        std::array<double, 3> color = {};
        for (std::size_t k = 0; k < 3; ++k) {
          depth += weights[k] * corners[k].z();
          facing += weights[k] * seen(mesh.normals[t[k]]).z();
          for (std::size_t c = 0; c < 3; ++c)
            color[c] += weights[k] * static_cast<double>(mesh.colors[t[k]][c]);
        }
        double& nearest = depths[static_cast<std::size_t>(y) * side + x];
        if (depth <= nearest) continue;
        nearest = depth;
        for (std::size_t c = 0; c < 3; ++c)
          image.texel(x, y)[c] =
              static_cast<float>(std::pow(std::clamp(color[c] * (0.25 + 0.75 * facing), 0.0, 1.0), 1 / 2.2));
      }
  }
  return image;
}

}  // namespace bakelight::tests
