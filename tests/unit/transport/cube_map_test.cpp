#include "transport/cube_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace bakelight::transport {
namespace {

TEST(CubeMap, SolidAnglesAddUpToTheSphere) {
  for (const int resolution : {1, 2, 3, 16, 64, 255}) {
    double face = 0;
    for (int y = 0; y < resolution; ++y)
      for (int x = 0; x < resolution; ++x) face += cubeTexelSolidAngle(x, y, resolution);
    EXPECT_NEAR(kCubeFaces * face, 4 * std::numbers::pi, 1e-11) << resolution;
  }
}

// dω = dA / r³ over a texel, by a fine midpoint rule.
TEST(CubeMap, SolidAngleIsTheIntegralOverTheTexel) {
  const int resolution = 4, steps = 200;
  for (int y = 0; y < resolution; ++y)
    for (int x = 0; x < resolution; ++x) {
      double integral = 0;
      for (int j = 0; j < steps; ++j)
        for (int i = 0; i < steps; ++i) {
          const double a = 2 * (x + (i + 0.5) / steps) / resolution - 1,
                       b = 2 * (y + (j + 0.5) / steps) / resolution - 1;
          integral += std::pow(a * a + b * b + 1, -1.5);
        }
      integral *= std::pow(2.0 / resolution / steps, 2);
      EXPECT_NEAR(cubeTexelSolidAngle(x, y, resolution), integral, 1e-6);
    }
}

// The OpenGL table: which direction a face's centre and upper left corner look.
TEST(CubeMap, FacesHaveOpenGlsOrderAndOrientation) {
  const Vec3 centers[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  const Vec3 upper_left[] = {{1, 1, 1}, {-1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {-1, 1, 1}, {1, 1, -1}};
  for (int face = 0; face < kCubeFaces; ++face) {
    EXPECT_LT((directionOfCubeFace(face, 0.5, 0.5) - centers[face]).norm(), 1e-12) << face;
    EXPECT_LT((directionOfCubeFace(face, 0, 0) - upper_left[face].normalized()).norm(), 1e-12) << face;
  }
}

TEST(CubeMap, DirectionAndFaceCoordinatesAreInverse) {
  for (int face = 0; face < kCubeFaces; ++face)
    for (double s = 0.05; s < 1; s += 0.1)
      for (double t = 0.05; t < 1; t += 0.1) {
        const CubeCoordinates back = cubeFaceOfDirection(directionOfCubeFace(face, s, t));
        EXPECT_EQ(back.face, face);
        EXPECT_NEAR(back.s, s, 1e-12);
        EXPECT_NEAR(back.t, t, 1e-12);
      }
}

}  // namespace
}  // namespace bakelight::transport
