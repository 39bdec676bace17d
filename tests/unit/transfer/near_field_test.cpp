#include "tools/transfer/near_field.h"

#include <gtest/gtest.h>

#include "formats/error.h"
#include "tests/support/shapes.h"
#include "tests/unit/transfer/bake.h"
#include "transport/sh.h"

namespace bakelight::transfer {
namespace {

using namespace bakelight::tests;
using transport::coefficientCount;

constexpr double kPi = std::numbers::pi;

TransferOptions nearField(int order, double sphere_radius, Transport transport = Transport::kUnshadowed) {
  return {.order = order, .directions = 65536, .transport = transport, .sphere_radius = sphere_radius};
}

// As the sphere grows the wall moves to infinity.
TEST(NearField, AHugeSphereIsDistantLight) {
  const TriangleMesh body = icosphere(1);
  const Transfer baked = bake(body, nearField(5, 1000));
  ASSERT_EQ(baked.near_vectors.size(), baked.vectors.size());
  double worst = 0, moved = 0;
  const Transfer close = bake(body, nearField(5, 1.5));
  for (std::size_t i = 0; i < baked.vectors.size(); ++i) {
    worst = std::max<double>(worst, std::abs(baked.near_vectors[i] - baked.vectors[i]));
    moved = std::max<double>(moved, std::abs(close.near_vectors[i] - close.vectors[i]));
  }
  EXPECT_LT(worst, 3e-3);
  EXPECT_GT(moved, 0.1);
}

// The whole wall at radiance 1 under the paper's formula: E/π = 1/π ∫ cos θ r²/d² dω over the wall, by a
// plain sum over the wall itself, at every order's band 0 … order − 1.
class NearFieldOrder : public testing::TestWithParam<int> {};

TEST_P(NearFieldOrder, EqualsTheIntegralOverTheWall) {
  const int order = GetParam(), count = coefficientCount(order);
  const TriangleMesh body = icosphere(0);
  const Transfer baked = bake(body, nearField(order, 2));
  ASSERT_NEAR(baked.sphere.radius, 2, 1e-6);
  const int heights = 400, turns = 400;
  for (const std::size_t v : {std::size_t{0}, std::size_t{5}}) {
    std::vector<double> expected(count, 0.0);
    const Vec3 x = vec3(body.positions[v]), n = vec3(body.normals[v]);
    for (int h = 0; h < heights; ++h)
      for (int k = 0; k < turns; ++k) {
        const double z = -1 + 2 * (h + 0.5) / heights, phi = 2 * kPi * (k + 0.5) / turns,
                     r = std::sqrt(1 - z * z);
        const Vec3 direction(r * std::cos(phi), r * std::sin(phi), z);
        const Vec3 to_wall = baked.sphere.center + 2 * direction - x;
        const double cosine = n.dot(to_wall.normalized());
        if (cosine <= 0) continue;
        const auto basis = transport::evaluateSh(order, direction);
        for (int i = 0; i < count; ++i)
          expected[i] += cosine * 4 / to_wall.squaredNorm() * basis[i] * (4 * kPi / (heights * turns)) / kPi;
      }
    for (int i = 0; i < count; ++i)
      EXPECT_NEAR(baked.near_vectors[v * count + i], expected[i], 2e-3) << "vertex " << v << " i " << i;
  }
}
INSTANTIATE_TEST_SUITE_P(Orders, NearFieldOrder, testing::Range(1, 11));

// A small source on the wall: E = I cos θ / d², as far as order 10 resolves a point. The error of cutting the
// bands is smallest where light falls straight down.
TEST(NearField, ASmallSourceOnTheWallFallsOffWithTheSquareOfItsDistance) {
  const int order = 10;
  const TriangleMesh body = icosphere(1);
  const Transfer baked = bake(body, nearField(order, 1.6));
  int compared = 0;
  for (std::size_t v = 0; v < body.vertexCount(); v += 3) {
    const Vec3 n = vec3(body.normals[v]);
    for (const double tilt : {0.0, 0.5}) {
      const Vec3 towards = (n + tilt * n.unitOrthogonal()).normalized();
      const Vec3 to_source = baked.sphere.center + 1.6 * towards - vec3(body.positions[v]);
      // Intensity 1: the cube map sees I/r² as its integral over directions.
      const auto basis = transport::evaluateSh(order, towards);
      double irradiance = 0;
      for (std::size_t i = 0; i < basis.size(); ++i)
        irradiance += kPi * baked.near_vectors[v * basis.size() + i] * basis[i] / (1.6 * 1.6);
      const double expected = n.dot(to_source.normalized()) / to_source.squaredNorm();
      EXPECT_NEAR(irradiance / expected, 1, 0.1) << "vertex " << v << " tilt " << tilt;
      ++compared;
    }
  }
  EXPECT_GT(compared, 20);
}

// The nearer wall counts more: on a plane, transfer is no longer the same everywhere (Fujita & Kanai, figure
// 1).
TEST(NearField, APlaneIsShadedUnevenly) {
  TriangleMesh plane = icosphere(0);  // only its extent matters
  plane.triangles.clear();
  plane.positions = {{-1, 0, 0}, {0, 0, 0}, {1, 0, 0}};
  plane.normals.assign(3, {0, 1, 0});
  const Transfer baked = bake(plane, nearField(5, 1.5));
  const auto light = transport::evaluateSh(5, Vec3(1, 1, 0).normalized());
  std::array<double, 3> lit{};
  for (std::size_t v = 0; v < 3; ++v)
    for (std::size_t i = 0; i < 25; ++i) lit[v] += baked.near_vectors[25 * v + i] * light[i];
  EXPECT_GT(lit[2], 1.3 * lit[1]);
  EXPECT_GT(lit[1], 1.3 * lit[0]);
}

TEST(NearField, AMeshWithoutExtentHasNoSphereAroundIt) {
  TriangleMesh point;
  point.positions = {{1, 2, 3}};
  point.normals = {{0, 0, 1}};
  EXPECT_THROW(bake(point, nearField(3, 2)), Error);
}

TEST(NearField, ShadowsAndBouncesApplyToo) {
  TriangleMesh pair = icosphere(2);
  append(pair, icosphere(2, 0.7, Vec3(1.8, 0.3, 0)));
  TransferOptions options = nearField(3, 2, Transport::kShadowed);
  options.directions = 2048;
  const Transfer shadowed = bake(pair, options);
  options.transport = Transport::kUnshadowed;
  const Transfer open = bake(pair, options);
  options.transport = Transport::kInterreflected;
  const Transfer bounced = bake(pair, options);
  double darker = 0, brighter = 0;
  for (std::size_t v = 0; v < pair.vertexCount(); ++v) {
    EXPECT_LE(shadowed.near_vectors[9 * v], open.near_vectors[9 * v] + 1e-5);
    EXPECT_GE(bounced.near_vectors[9 * v], shadowed.near_vectors[9 * v] - 1e-3);
    darker += open.near_vectors[9 * v] - shadowed.near_vectors[9 * v];
    brighter += bounced.near_vectors[9 * v] - shadowed.near_vectors[9 * v];
  }
  EXPECT_GT(darker, 1);
  EXPECT_GT(brighter, 0.5);
}

}  // namespace
}  // namespace bakelight::transfer
