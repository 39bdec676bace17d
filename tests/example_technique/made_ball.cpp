#include "tests/example_technique/made_ball.h"

#include <algorithm>
#include <cmath>

#include "transport/vector_types.h"

namespace bakelight::example {
namespace {

using transport::Vec3;

Vec3 shown(const Vec3& normal) {
  const Vec3 window = Vec3(-0.5, 0.6, 0.62).normalized(), clay(0.62, 0.25, 0.13);
  const double lit = std::max(0.0, normal.dot(window)), sky = 0.5 + 0.5 * normal.y();
  const Vec3 mirrored = 2 * normal.z() * normal - Vec3::UnitZ();
  const double shine = std::pow(std::max(0.0, mirrored.dot(window)), 60);
  const double rim = std::pow(1 - normal.z(), 4);
  return clay.cwiseProduct(1.1 * lit * Vec3(1, 0.93, 0.8) + 0.35 * sky * Vec3(0.6, 0.8, 1) +
                           Vec3::Constant(0.08)) +
         0.9 * shine * Vec3(1, 0.95, 0.9) + 0.35 * rim * Vec3(0.5, 0.7, 1);
}

}  // namespace

formats::PackImage madeBallPicture(int edge, formats::Precision precision) {
  std::vector<float> texels;
  for (int row = 0; row < edge; ++row)
    for (int column = 0; column < edge; ++column) {
      Eigen::Vector2d place(2 * (column + 0.5) / edge - 1, 1 - 2 * (row + 0.5) / edge);
      if (place.norm() > 1) place.normalize();  // beyond the ball its rim goes on
      const Vec3 color = shown({place.x(), place.y(), std::sqrt(std::max(0.0, 1 - place.squaredNorm()))});
      for (const double value : color) texels.push_back(static_cast<float>(value));
    }
  return {edge, edge, {"R", "G", "B"}, formats::encodeTable(texels, 3, precision, "made", "picture")};
}

}  // namespace bakelight::example
