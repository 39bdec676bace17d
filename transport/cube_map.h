// Cube maps in OpenGL's face order (+X, −X, +Y, −Y, +Z, −Z) and orientation, with exact texel solid angles.
#pragma once

#include <array>

#include "formats/image.h"
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

// A cube map as one image: its faces side by side (6:1) or one below the other (1:6).
struct CubeStrip {
  int resolution_px;
  bool side_by_side;

  // In image coordinates.
  std::array<int, 2> texelAt(int face, int x, int y) const {
    return {side_by_side ? face * resolution_px + x : x, side_by_side ? y : face * resolution_px + y};
  }
};
// Throws Error(kBadInput) naming `file` for another shape.
CubeStrip cubeStrip(const formats::Image& strip, const std::string& file);

// Radiance towards `direction`, bilinear within a face. The image's channels are R, G, B.
Float3 lookUpCubeMap(const formats::Image& strip, const Vec3& direction);

}  // namespace bakelight::transport
