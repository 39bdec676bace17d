// Cube maps in OpenGL's face order (+X, −X, +Y, −Y, +Z, −Z) and orientation, with exact texel solid angles.
#pragma once

#include <array>

#include "transport/vector_types.h"

namespace bakelight::transport {

inline constexpr int kCubeFaces = 6;

// Unit direction through face coordinates s, t in [0, 1] (s right, t down, as the image of a face is stored).
Vec3 directionOfCubeFace(int face, double s, double t);

struct CubeCoordinates {
  int face;
  double s, t;
};
CubeCoordinates cubeFaceOfDirection(const Vec3& direction);

// Steradians that texel (x, y) of a face of resolution² texels covers: the four-corner arctangent formula,
// exact. The six faces add up to 4π.
double cubeTexelSolidAngle(int x, int y, int resolution);

}  // namespace bakelight::transport
