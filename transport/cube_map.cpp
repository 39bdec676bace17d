#include "transport/cube_map.h"

#include <cmath>

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

}  // namespace bakelight::transport
