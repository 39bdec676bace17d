#include "tools/transfer/transfer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>

#include "formats/error.h"
#include "tests/support/shapes.h"
#include "tests/unit/transfer/bake.h"
#include "tools/transfer/transfer_file.h"
#include "transport/diffusion.h"
#include "transport/sh.h"

namespace bakelight::transfer {
namespace {

using namespace bakelight::tests;
using transport::coefficientCount;

constexpr double kPi = std::numbers::pi;

TransferOptions shadowed(int order, int directions = 4096) {
  return {.order = order, .directions = directions, .transport = Transport::kShadowed};
}

TransferOptions unshadowed(int order) {
  return {.order = order, .transport = Transport::kUnshadowed};
}

// albedo/π · A_l · y_lm(n)
std::vector<double> unshadowedVector(int order, const Vec3& normal) {
  std::vector<double> vector = transport::evaluateSh(order, normal);
  const std::vector<double> factors = transport::clampedCosineFactors(order);
  for (int l = 0; l < order; ++l)
    for (int i = l * l; i < (l + 1) * (l + 1); ++i) vector[i] *= factors[l] / kPi;
  return vector;
}

TEST(BakeableMesh, NormalWithoutUnitLengthIsNamed) {
  const std::string file = std::string(BAKELIGHT_SOURCE_DIR) + "/tests/cases/far/huge_normal.ply";
  try {
    readBakeableMesh(file);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.place().file, file);
    EXPECT_EQ(error.place().element, "vertex 3");
  }
}

class TransferOrder : public testing::TestWithParam<int> {};

TEST_P(TransferOrder, UnshadowedIsTheClosedForm) {
  const TriangleMesh sphere = icosphere(2);
  const int count = coefficientCount(GetParam());
  const Transfer baked = bake(sphere, unshadowed(GetParam()));
  ASSERT_EQ(baked.vectors.size(), sphere.vertexCount() * count);
  EXPECT_EQ(baked.rays, 0u);
  for (std::size_t v = 0; v < sphere.vertexCount(); ++v) {
    const std::vector<double> expected = unshadowedVector(GetParam(), vec3(sphere.normals[v]));
    for (int i = 0; i < count; ++i) EXPECT_NEAR(baked.vectors[v * count + i], expected[i], 1e-7);
  }
}

TEST_P(TransferOrder, ConvexBodyShadowedEqualsUnshadowed) {
  const TriangleMesh sphere = icosphere(3);
  const Transfer baked = bake(sphere, shadowed(GetParam()));
  EXPECT_EQ(baked.blocked_rays, 0u);
  EXPECT_GT(baked.rays, sphere.vertexCount() * 2000);
  EXPECT_EQ(baked.vectors, bake(sphere, unshadowed(GetParam())).vectors);
}

// What enters a medium: the closed form of its own kernel, by rays too, and under a uniform sky the share that enters.
TEST_P(TransferOrder, OfAMediumIsWhatEnters) {
  const TriangleMesh sphere = icosphere(3);
  const int order = GetParam(), count = coefficientCount(order);
  for (const double eta : {1.0, 1.5}) {
    TransferOptions options = unshadowed(order);
    options.entered_ior = eta;
    const Transfer baked = bake(sphere, options);
    const std::vector<double> factors = transport::enteringCosineFactors(order, eta);
    for (std::size_t v = 0; v < sphere.vertexCount(); v += 7) {
      const std::vector<double> basis = transport::evaluateSh(order, vec3(sphere.normals[v]));
      for (int l = 0; l < order; ++l)
        for (int i = l * l; i < (l + 1) * (l + 1); ++i)
          EXPECT_NEAR(baked.vectors[v * count + i], factors[l] / kPi * basis[i], 1e-6);
    }
    options.transport = Transport::kShadowed;
    options.directions = 4096;
    EXPECT_EQ(bake(sphere, options).vectors, baked.vectors);
  }
}

// Half of the sky shut off by a wall: what enters comes from the other half, whichever way it is weighted.
TEST(TransferOfAMedium, LosesHalfToAWall) {
  TriangleMesh mesh = icosphere(1, 0.01);
  TriangleMesh wall;
  wall.positions = {{0.02F, -500, -500}, {0.02F, 500, -500}, {0.02F, 500, 500}, {0.02F, -500, 500}};
  wall.normals.assign(4, Float3{-1, 0, 0});
  wall.triangles = {{0, 2, 1}, {0, 3, 2}};
  append(mesh, wall);
  TransferOptions options = shadowed(1, 16384);
  std::size_t checked = 0;
  for (const double eta : {0.0, 1.5}) {
    options.entered_ior = eta;
    const Transfer baked = bake(mesh, options);
    options.transport = Transport::kUnshadowed;
    const Transfer open = bake(mesh, options);
    options.transport = Transport::kShadowed;
    for (std::size_t v = 0; v + 4 < mesh.vertexCount(); ++v) {
      if (std::abs(mesh.normals[v][0]) > 1e-3F) continue;
      EXPECT_NEAR(baked.vectors[v] / open.vectors[v], 0.5, 0.02) << eta;
      ++checked;
    }
  }
  EXPECT_GT(checked, 6U);
}

// Furnace: a white convex body under a uniform sky of radiance 1 leaves radiance 1.
TEST_P(TransferOrder, FurnaceGivesBackTheSky) {
  const TriangleMesh sphere = icosphere(2);
  const int count = coefficientCount(GetParam());
  const Transfer baked = bake(sphere, shadowed(GetParam()));
  for (std::size_t v = 0; v < sphere.vertexCount(); ++v)
    EXPECT_NEAR(baked.vectors[v * count] * std::sqrt(4 * kPi), 1, 1e-6);
}

// Ground under a coaxial disk that subtends half angle a: all coefficients are zonal about +Y, with
// T_l0 = 1/π ∫_0^{cos a} 2π z √((2l+1)/4π) P_l(z) dz.
TEST_P(TransferOrder, GroundUnderADisk) {
  const int order = GetParam(), count = coefficientCount(order);
  for (const double half_angle : {0.2, 0.7, 1.2}) {
    TriangleMesh mesh = diskFacingDown(Vec3(0, 1, 0), std::tan(half_angle), 720);
    mesh.positions.push_back({0, 0, 0});
    mesh.normals.push_back({0, 1, 0});
    const Transfer baked = bake(mesh, shadowed(order, 16384));

    std::vector<double> zonal(order, 0.0);
    const int steps = 20000;
    for (int s = 0; s < steps; ++s) {
      const double z = std::cos(half_angle) * (s + 0.5) / steps;
      const std::vector<double> p = transport::legendre(order, z);
      for (int l = 0; l < order; ++l)
        zonal[l] += 2 * z * std::sqrt((2 * l + 1) / (4 * kPi)) * p[l] * std::cos(half_angle) / steps;
    }
    const std::vector<double> expected = transport::orientZonal(zonal, Vec3(0, 1, 0));
    const float* vector = &baked.vectors[(mesh.vertexCount() - 1) * count];
    // The rim of the disk cuts through cells of 4π/16384 sr; measured error 5e-4, the bound leaves a factor
    // of three.
    for (int i = 0; i < count; ++i)
      EXPECT_NEAR(vector[i], expected[i], 1.5e-3) << "half angle " << half_angle << " i " << i;
  }
}

// Lambert: a sphere of radius r at distance d, its centre at angle θ from the normal and wholly above the
// horizon, has the configuration factor (r/d)² cos θ.
TEST(Transfer, SphereOverGround) {
  for (const double angle : {0.0, 0.6, 1.0}) {
    const double radius = 0.9, distance = 2.2;
    TriangleMesh mesh = icosphere(3, radius, distance * Vec3(std::sin(angle), std::cos(angle), 0));
    // Cauchy: a convex body's mean silhouette is a quarter of its surface, so the inscribed icosphere hides
    // that much less.
    const double silhouette_ratio = surfaceArea(mesh) / (4 * kPi * radius * radius);
    mesh.positions.push_back({0, 0, 0});
    mesh.normals.push_back({0, 1, 0});
    const Transfer baked = bake(mesh, shadowed(1, 16384));
    const double factor = std::pow(radius / distance, 2) * std::cos(angle);
    const double visible = baked.vectors.back() * std::sqrt(4 * kPi);
    // The rim of the sphere crosses cells of 4π/16384 sr: about 40 of them, half a cell of either sign each.
    EXPECT_NEAR(visible, 1 - silhouette_ratio * factor, 1.5e-3) << "angle " << angle;
  }
}

INSTANTIATE_TEST_SUITE_P(Orders, TransferOrder, testing::Range(1, 11));

TEST(Transfer, NothingIsSeenInsideAClosedBody) {
  const TriangleMesh cave = insideOut(icosphere(3));
  const Transfer baked = bake(cave, shadowed(5));
  EXPECT_EQ(baked.fully_blocked_vertices, cave.vertexCount());
  EXPECT_EQ(baked.buried_vertices, 0u);
  for (const float value : baked.vectors) EXPECT_EQ(value, 0);
}

// Two spheres that overlap: what lies inside the other one takes over the transfer of the rim, instead of
// staining it black.
TEST(Transfer, VerticesInsideAnotherPartAreFilledFromTheirNeighbors) {
  TriangleMesh pair = icosphere(3);
  const std::size_t first = pair.vertexCount();
  append(pair, icosphere(3, 0.8, Vec3(0.9, 0, 0)));
  const Transfer baked = bake(pair, shadowed(3));
  std::size_t inside = 0;
  for (std::size_t v = 0; v < pair.vertexCount(); ++v) {
    const Vec3 p = vec3(pair.positions[v]);
    const bool is_inside = v < first ? (p - Vec3(0.9, 0, 0)).norm() < 0.79 : p.norm() < 0.98;
    inside += is_inside ? 1 : 0;
    // y_00 · visible share: well above black everywhere, at most unshadowed.
    EXPECT_GT(baked.vectors[v * 9], 0.25 * std::sqrt(1 / (4 * kPi))) << "vertex " << v;
    EXPECT_LE(baked.vectors[v * 9], 1.001 * std::sqrt(1 / (4 * kPi))) << "vertex " << v;
  }
  EXPECT_GT(inside, 100u);
  EXPECT_GE(baked.buried_vertices, inside);
  EXPECT_EQ(baked.filled_vertices, baked.buried_vertices);
}

TEST(Transfer, AComponentThatIsBuriedAsAWholeStaysBlack) {
  TriangleMesh nested = icosphere(3);
  const std::size_t first = nested.vertexCount();
  append(nested, icosphere(2, 0.3));
  const Transfer baked = bake(nested, shadowed(2));
  EXPECT_EQ(baked.buried_vertices, nested.vertexCount() - first);
  EXPECT_EQ(baked.filled_vertices, 0u);
  for (std::size_t i = first * 4; i < baked.vectors.size(); ++i) EXPECT_EQ(baked.vectors[i], 0);
}

TEST(Transfer, HigherOrderBeginsWithTheLowerOne) {
  TriangleMesh pair = icosphere(2);
  append(pair, icosphere(2, 0.7, Vec3(1.8, 0.3, 0)));
  const Transfer low = bake(pair, shadowed(3)), high = bake(pair, shadowed(7));
  ASSERT_GT(low.blocked_rays, 0u);
  for (std::size_t v = 0; v < pair.vertexCount(); ++v)
    for (int i = 0; i < 9; ++i) EXPECT_EQ(low.vectors[v * 9 + i], high.vectors[v * 49 + i]);
}

TEST(Transfer, TurningTheBodyTurnsTheVectors) {
  const int order = 5, count = coefficientCount(order);
  TriangleMesh pair = icosphere(2);
  append(pair, icosphere(2, 0.7, Vec3(1.8, 0.3, 0)));
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.234, Vec3(1, 2, -0.5).normalized()).toRotationMatrix();
  TriangleMesh turned = pair;
  for (auto& p : turned.positions) p = float3(turn * vec3(p));
  for (auto& n : turned.normals) n = float3(turn * vec3(n));

  const Transfer before = bake(pair, shadowed(order, 16384)), after = bake(turned, shadowed(order, 16384));
  const transport::ShRotation rotation(order, turn);
  double error2 = 0, norm2 = 0;
  for (std::size_t v = 0; v < pair.vertexCount(); ++v) {
    const std::vector<double> source(&before.vectors[v * count], &before.vectors[v * count] + count);
    std::vector<double> expected(count);
    rotation.apply(std::span<const double>(source), std::span<double>(expected));
    for (int i = 0; i < count; ++i) {
      error2 += std::pow(after.vectors[v * count + i] - expected[i], 2);
      norm2 += expected[i] * expected[i];
    }
  }
  // Two different sets of rays against the same blockers: what differs is quadrature error alone.
  EXPECT_LT(std::sqrt(error2 / norm2), 2e-3);
  EXPECT_GT(std::sqrt(error2 / norm2), 0);
}

TEST(Transfer, ScaleAndPlaceDoNotMatter) {
  TriangleMesh pair = icosphere(2);
  append(pair, icosphere(2, 0.7, Vec3(1.8, 0.3, 0)));
  const Transfer reference = bake(pair, shadowed(4));
  for (const double scale : {1e-6, 1e6}) {
    TriangleMesh scaled = pair;
    for (auto& p : scaled.positions) p = float3(scale * vec3(p));
    const Transfer baked = bake(scaled, shadowed(4));
    ASSERT_EQ(baked.vectors.size(), reference.vectors.size());
    double worst = 0;
    for (std::size_t i = 0; i < baked.vectors.size(); ++i)
      worst = std::max<double>(worst, std::abs(baked.vectors[i] - reference.vectors[i]));
    // A few rays that graze an edge may fall on its other side.
    EXPECT_LT(worst, 5e-3) << "scale " << scale;
  }
}

TEST(Transfer, SameBytesWithAnyNumberOfThreads) {
  TriangleMesh pair = icosphere(3);
  append(pair, icosphere(3, 0.7, Vec3(1.8, 0.3, 0)));
  const Transfer many = bake(pair, shadowed(5));
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Transfer single = bake(pair, shadowed(5));
  EXPECT_EQ(single.vectors, many.vectors);
  EXPECT_EQ(single.quadrature_error, many.quadrature_error);
  EXPECT_EQ(single.blocked_rays, many.blocked_rays);
}

TEST(Transfer, OneVertexAndNoTriangles) {
  TriangleMesh point;
  point.positions = {{1, 2, 3}};
  point.normals = {{0, 0, 1}};
  EXPECT_EQ(bake(point, shadowed(5)).vectors, bake(point, unshadowed(5)).vectors);
}

}  // namespace
}  // namespace bakelight::transfer
