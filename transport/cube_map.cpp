#include "transport/cube_map.h"

#include <algorithm>
#include <cmath>

#include "formats/error.h"

namespace bakelight::transport {
namespace {

// Of OpenGL 4.5's table 8.19: a direction is major + sc · s_axis + tc · t_axis with sc, tc in [-1, 1].
struct Face {
  Vec3 major, s_axis, t_axis;
};

const std::array<Face, kCubeFaces>& faces() {
  static const std::array<Face, kCubeFaces> table = {{
      {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}},
      {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
      {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},
      {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
      {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},
      {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}},
  }};
  return table;
}

// Solid angle of the face's part from its centre to (a, b), signed.
double cornerAngle(double a, double b) {
  return std::atan2(a * b, std::sqrt(a * a + b * b + 1));
}

}  // namespace

Vec3 directionOfCubeFace(int face, double s, double t) {
  const Face& f = faces().at(face);
  return (f.major + (2 * s - 1) * f.s_axis + (2 * t - 1) * f.t_axis).normalized();
}

CubeCoordinates cubeFaceOfDirection(const Vec3& direction) {
  Eigen::Index axis = 0;
  const double size = direction.cwiseAbs().maxCoeff(&axis);
  const int face = static_cast<int>(2 * axis) + (direction[axis] < 0 ? 1 : 0);
  const Face& f = faces()[face];
  return {face, (direction.dot(f.s_axis) / size + 1) / 2, (direction.dot(f.t_axis) / size + 1) / 2};
}

double cubeTexelSolidAngle(int x, int y, int resolution) {
  const double left = 2.0 * x / resolution - 1, right = 2.0 * (x + 1) / resolution - 1;
  const double upper = 2.0 * y / resolution - 1, lower = 2.0 * (y + 1) / resolution - 1;
  return cornerAngle(right, lower) - cornerAngle(left, lower) - cornerAngle(right, upper) +
         cornerAngle(left, upper);
}

CubeStrip cubeStrip(const formats::Image& strip, const std::string& file) {
  const int width = strip.width, height = strip.height;
  if (height > 0 && width == kCubeFaces * height) return {height, true};
  if (width > 0 && height == kCubeFaces * width) return {width, false};
  throw badInput(
      {file, "", ""},
      "is " + std::to_string(width) + " × " + std::to_string(height) + " pixels, so it is no cube map",
      "six square faces +X −X +Y −Y +Z −Z, side by side or one below the other");
}

Float3 lookUpCubeMap(const formats::Image& strip, const Vec3& direction) {
  const CubeStrip layout = cubeStrip(strip, "cube map");
  const auto [face, s, t] = cubeFaceOfDirection(direction);
  const double last = layout.resolution_px - 1;
  const double x = std::clamp(s * layout.resolution_px - 0.5, 0.0, last);
  const double y = std::clamp(t * layout.resolution_px - 0.5, 0.0, last);
  const int left = static_cast<int>(x), upper = static_cast<int>(y);
  const int right = std::min(left + 1, layout.resolution_px - 1),
            lower = std::min(upper + 1, layout.resolution_px - 1);
  const auto across = static_cast<float>(x - left), down = static_cast<float>(y - upper);

  Float3 radiance;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto at = [&, face = face](int tx, int ty) {
      const auto [column, row] = layout.texelAt(face, tx, ty);
      return strip.texel(column, row)[c];
    };
    const float above = at(left, upper) + across * (at(right, upper) - at(left, upper));
    const float below = at(left, lower) + across * (at(right, lower) - at(left, lower));
    radiance[c] = above + down * (below - above);
  }
  return radiance;
}

}  // namespace bakelight::transport
