#include "tools/transfer/matrices.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "tests/support/shapes.h"
#include "tests/unit/transfer/bake.h"
#include "transport/directions.h"

namespace bakelight::transfer {
namespace {

using namespace bakelight::tests;
using transport::coefficientCount;

constexpr double kPi = std::numbers::pi;

TriangleMesh pairOfSpheres() {
  TriangleMesh pair = icosphere(1);
  append(pair, icosphere(1, 0.7, Vec3(1.8, 0.3, 0)));
  return pair;
}
TransferOptions glossy(Transport transport, int row_order, int order, int directions = 4096) {
  return {.order = order,
          .directions = directions,
          .transport = transport,
          .glossy = Glossy::kMatrices,
          .row_order = row_order};
}

class MatrixOrders : public testing::TestWithParam<std::pair<int, int>> {};

// Convex body: M_ij = ∫ over the hemisphere of y_i(local s) y_j(s).
TEST_P(MatrixOrders, UnshadowedIsTheHemisphere) {
  const auto [row_order, order] = GetParam();
  const int rows = coefficientCount(row_order), columns = coefficientCount(order);
  const TriangleMesh sphere = icosphere(0);
  const Transfer baked = bake(sphere, glossy(Transport::kUnshadowed, row_order, order));
  ASSERT_EQ(baked.matrices.size(), sphere.vertexCount() * rows * columns);
  // Exact quadrature over the hemisphere: Gauss–Legendre would do; a fine product rule of midpoints is enough
  // for 1e-4.
  for (const std::size_t v : {std::size_t{0}, std::size_t{7}}) {
    const Eigen::Matrix3d local = localFromObject(sphere.normals[v], baked.tangents[v]);
    Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(rows, columns);
    const int heights = 500, turns = 32;
    for (int h = 0; h < heights; ++h)
      for (int k = 0; k < turns; ++k) {
        const double z = (h + 0.5) / heights, r = std::sqrt(1 - z * z), phi = 2 * kPi * (k + 0.5) / turns;
        const Vec3 s_local(r * std::cos(phi), r * std::sin(phi), z);
        const auto y_local = transport::evaluateSh(row_order, s_local);
        const auto y = transport::evaluateSh(order, Vec3(local.transpose() * s_local));
        expected += Eigen::Map<const Eigen::VectorXd>(y_local.data(), rows) *
                    Eigen::Map<const Eigen::RowVectorXd>(y.data(), columns) * (2 * kPi / (heights * turns));
      }
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < columns; ++j)
        ASSERT_NEAR(baked.matrices[(v * rows + i) * columns + j], expected(i, j), 5e-4) << i << ", " << j;
  }
}

// Row by the clamped cosine: the matrix contracted with A_l in the local frame is the diffuse vector, exactly
// while the rows hold all bands of the cosine that the product with visibility needs; here the body is
// convex.
TEST_P(MatrixOrders, ShadowedConvexBodyEqualsUnshadowed) {
  const auto [row_order, order] = GetParam();
  const TriangleMesh sphere = icosphere(2);
  const Transfer shadowed = bake(sphere, glossy(Transport::kShadowed, row_order, order, 512));
  EXPECT_EQ(shadowed.blocked_rays, 0u);
  const Transfer unshadowed = bake(sphere, glossy(Transport::kUnshadowed, row_order, order));
  ASSERT_EQ(shadowed.matrices.size(), unshadowed.matrices.size());
  for (std::size_t i = 0; i < shadowed.matrices.size(); ++i)
    ASSERT_NEAR(shadowed.matrices[i], unshadowed.matrices[i], 2e-6);
}

INSTANTIATE_TEST_SUITE_P(Orders, MatrixOrders,
                         testing::Values(std::pair(1, 1), std::pair(2, 3), std::pair(3, 3), std::pair(4, 4),
                                         std::pair(5, 5), std::pair(5, 3), std::pair(3, 5), std::pair(6, 6),
                                         std::pair(7, 7), std::pair(8, 2), std::pair(9, 9),
                                         std::pair(10, 10)));

// The matrix from the visibility vector is what the rays themselves give, product by product.
TEST(Matrices, EqualTheSumOverVisibleRays) {
  const TriangleMesh pair = pairOfSpheres();
  const TransferOptions options = glossy(Transport::kShadowed, 4, 3, 4096);
  const Transfer baked = bake(pair, options);
  const transport::RayScene scene(pair);
  const auto directions = transport::sphereDirections(65536);
  const auto points = frontPoints(pair, options.bias);
  double difference = 0, size = 0;
  for (std::size_t v = 0; v < pair.vertexCount(); v += 5) {
    const Eigen::Matrix3d local = localFromObject(pair.normals[v], baked.tangents[v]);
    Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(16, 9);
    for (const Vec3& s : directions) {
      if (s.dot(vec3(pair.normals[v])) <= 0 || scene.nearestHit(vec3(points[v].origin), s).valid) continue;
      const auto y_local = transport::evaluateSh(4, Vec3(local * s));
      const auto y = transport::evaluateSh(3, s);
      expected += Eigen::Map<const Eigen::VectorXd>(y_local.data(), 16) *
                  Eigen::Map<const Eigen::RowVectorXd>(y.data(), 9) * (4 * kPi / 65536);
    }
    for (int i = 0; i < 16; ++i)
      for (int j = 0; j < 9; ++j) {
        difference += std::pow(baked.matrices[(v * 16 + i) * 9 + j] - expected(i, j), 2);
        size += std::pow(expected(i, j), 2);
      }
  }
  // Two quadratures of a discontinuous function.
  EXPECT_LT(std::sqrt(difference / size), 0.01);
}

TEST(Matrices, VisibilityHoldsTheSameMatrices) {
  const TriangleMesh pair = pairOfSpheres();
  TransferOptions options = glossy(Transport::kShadowed, 5, 5, 1024);
  const Transfer full = bake(pair, options);
  options.glossy = Glossy::kVisibility;
  const Transfer compact = bake(pair, options);
  ASSERT_EQ(compact.visibility.size(), pair.vertexCount() * 81);
  EXPECT_TRUE(compact.matrices.empty());
  const MatrixBaker baker(5, 5);
  for (std::size_t v = 0; v < pair.vertexCount(); ++v) {
    std::vector<float> matrix(625);
    baker.fromVisibility(std::span(compact.visibility).subspan(v * 81, 81), matrix);
    baker.turnRows(localFromObject(pair.normals[v], compact.tangents[v]), matrix);
    for (std::size_t i = 0; i < 625; ++i) ASSERT_EQ(matrix[i], full.matrices[v * 625 + i]);
  }
}

// White surfaces under a uniform sky: light arrives with radiance 1 from every direction above the horizon,
// from the sky or from the surface that hides it, so the transferred radiance is that of the unshadowed
// hemisphere.
TEST(Matrices, WhiteFurnaceFillsTheShadows) {
  const TriangleMesh pair = [] {
    TriangleMesh mesh = icosphere(3);
    append(mesh, icosphere(3, 0.7, Vec3(1.8, 0.3, 0)));
    return mesh;
  }();
  TransferOptions options = glossy(Transport::kInterreflected, 3, 2, 2048);
  options.interreflection.threshold = 1e-4;
  const Transfer white = bake(pair, options);
  const Transfer open = bake(pair, glossy(Transport::kUnshadowed, 3, 2));
  const Transfer shadowed = bake(pair, glossy(Transport::kShadowed, 3, 2, 2048));
  ASSERT_EQ(white.matrices.size(), open.matrices.size());
  double worst = 0, shadow = 0;
  for (std::size_t v = 0; v < pair.vertexCount(); ++v)
    for (std::size_t i = 0; i < 9; ++i) {
      const std::size_t at = (v * 9 + i) * 4;  // column 0: the uniform sky
      worst = std::max<double>(worst, std::abs(white.matrices[at] - open.matrices[at]));
      shadow = std::max<double>(shadow, std::abs(shadowed.matrices[at] - open.matrices[at]));
    }
  EXPECT_GT(shadow, 0.05);
  EXPECT_LT(worst, 5e-3);
}

TEST(Matrices, ColoredBouncesNeedThreeChannels) {
  const TriangleMesh pair = pairOfSpheres();
  const std::vector<Float3> colored = {{0.9f, 0.5f, 0.1f}};
  const Transfer baked = bake(pair, glossy(Transport::kInterreflected, 2, 2, 512), colored);
  EXPECT_EQ(baked.channels, 3);
  EXPECT_EQ(baked.matrices.size(), pair.vertexCount() * 3 * 16);
  double red = 0, blue = 0;
  for (std::size_t v = 0; v < pair.vertexCount(); ++v)
    red += baked.matrices[v * 48], blue += baked.matrices[v * 48 + 32];
  EXPECT_GT(red, blue * 1.001);
}

TEST(Matrices, SameBytesWithAnyNumberOfThreads) {
  const TriangleMesh pair = pairOfSpheres();
  const std::vector<Float3> colored = {{0.9f, 0.5f, 0.1f}};
  const auto options = glossy(Transport::kInterreflected, 4, 3, 1024);
  const Transfer many = bake(pair, options, colored);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(bake(pair, options, colored).matrices, many.matrices);
}

}  // namespace
}  // namespace bakelight::transfer
