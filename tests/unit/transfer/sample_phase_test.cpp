#include "tools/transfer/sample_phase.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "tests/support/shapes.h"
#include "tests/unit/transfer/bake.h"
#include "transport/sh.h"

namespace bakelight::transfer {
namespace {

using namespace bakelight::tests;

constexpr double kPi = std::numbers::pi;

TransferOptions fitted(Transport transport, int order = 3) {
  return {.order = order, .directions = 2048, .transport = transport, .fit = Fit::kLeastSquares};
}
TransferOptions atVertices(TransferOptions options) {
  options.fit = Fit::kVertices;
  return options;
}
TriangleMesh twoSpheres() {
  TriangleMesh pair = icosphere(2);
  append(pair, icosphere(2, 0.7, Vec3(1.8, 0.3, 0)));
  return pair;
}

// √ of the mean over a sphere's triangles of |interpolated − closed form|², at places that no sample has.
double errorOnSphere(const TriangleMesh& sphere, const std::vector<float>& vectors, int order) {
  const std::vector<double> cosine = transport::clampedCosineFactors(order);
  const auto size = static_cast<std::size_t>(transport::coefficientCount(order));
  double sum = 0;
  for (const auto& triangle : sphere.triangles)
    for (const Vec3& weights :
         {Vec3(0.6, 0.2, 0.2), Vec3(0.2, 0.6, 0.2), Vec3(0.2, 0.2, 0.6), Vec3(0.05, 0.05, 0.9)}) {
      Vec3 normal = Vec3::Zero();
      for (int i = 0; i < 3; ++i) normal += weights[i] * vec3(sphere.normals[triangle[i]]);
      const std::vector<double> basis = transport::evaluateSh(order, normal.normalized());
      for (int l = 0; l < order; ++l)
        for (int i = l * l; i < (l + 1) * (l + 1); ++i) {
          double shown = 0;
          for (int k = 0; k < 3; ++k) shown += weights[k] * vectors[triangle[k] * size + i];
          sum += std::pow(shown - cosine[l] / kPi * basis[i], 2);
        }
    }
  return std::sqrt(sum / static_cast<double>(4 * sphere.triangleCount()));
}

TEST(LeastSquares, ErrLessBetweenTheVerticesOfASphere) {
  const TriangleMesh sphere = icosphere(1);
  for (const Transport transport : {Transport::kUnshadowed, Transport::kShadowed}) {
    const TransferOptions options = fitted(transport, 5);
    const Transfer baked = bake(sphere, options), sampled = bake(sphere, atVertices(options));
    const double error = errorOnSphere(sphere, baked.vectors, 5);
    EXPECT_LT(error, 0.7 * errorOnSphere(sphere, sampled.vectors, 5));
    EXPECT_LT(baked.fit.error, 0.7 * baked.fit.error_at_vertices);
    EXPECT_EQ(baked.fit.samples, 8U * sphere.triangleCount());
    EXPECT_EQ(baked.fit.limited_vertices, 0U);
  }
}

// Exact as it is: nothing may change, not by a bit.
TEST(LeastSquares, LeaveAPlaneInTheOpenAsItIs) {
  const TriangleMesh plane = diskFacingDown(Vec3(0.1, 0.2, 0.3), 1.3, 7);
  for (const Transport transport :
       {Transport::kUnshadowed, Transport::kShadowed, Transport::kInterreflected}) {
    const TransferOptions options = fitted(transport, 4);
    EXPECT_EQ(bake(plane, options).vectors, bake(plane, atVertices(options)).vectors);
  }
}

TEST(LeastSquares, KeepAWhiteFurnaceWhite) {
  const TriangleMesh pair = twoSpheres();
  TransferOptions options = fitted(Transport::kInterreflected);
  options.interreflection.threshold = 1e-6;
  const Transfer baked = bake(pair, options);
  EXPECT_GT(baked.fit.error_at_vertices, 0.01);
  for (std::size_t v = 0; v < pair.vertexCount(); ++v)
    ASSERT_NEAR(std::sqrt(4 * kPi) * baked.vectors[9 * v], 1, 1e-4) << v;
}

// A hollow bowl, of whose back some is seen.
TEST(LeastSquares, GatherWhatBouncesAsVerticesDo) {
  TriangleMesh bowl = insideOut(icosphere(2));
  std::erase_if(bowl.triangles, [&](const formats::Triangle& t) {
    return bowl.positions[t[0]][1] + bowl.positions[t[1]][1] + bowl.positions[t[2]][1] > 0;
  });
  append(bowl, icosphere(1, 0.3, Vec3(0, -1.6, 0)));
  const std::vector<Float3> albedo = {{0.8F, 0.6F, 0.4F}};
  const TransferOptions options = fitted(Transport::kInterreflected);
  const Transfer baked = bake(bowl, options, albedo), sampled = bake(bowl, atVertices(options), albedo);
  ASSERT_EQ(baked.channels, 3);
  double difference = 0, all = 0;
  for (std::size_t i = 0; i < baked.vectors.size(); ++i) {
    difference += std::pow(baked.vectors[i] - sampled.vectors[i], 2);
    all += std::pow(sampled.vectors[i], 2);
  }
  EXPECT_LT(std::sqrt(difference / all), 0.08);
  EXPECT_GT(baked.back_points, 0U);
}

TEST(LeastSquares, DoNotLookAtWhatIsBuried) {
  TriangleMesh scene = icosphere(3);
  append(scene, icosphere(2, 0.5, Vec3(1, 0, 0)));
  const Transfer baked = bake(scene, fitted(Transport::kShadowed));
  EXPECT_GT(baked.fit.buried_samples, 100U);
  EXPECT_GE(baked.fit.least_shown, 0);
  for (std::size_t v = 0; v < scene.vertexCount(); ++v) ASSERT_GE(baked.vectors[9 * v], 0) << v;
}

TEST(LeastSquares, FitNearFieldsToo) {
  const TriangleMesh sphere = icosphere(1);
  TransferOptions options = fitted(Transport::kUnshadowed);
  options.sphere_radius = 1000;
  const Transfer baked = bake(sphere, options);
  ASSERT_EQ(baked.near_vectors.size(), baked.vectors.size());
  for (std::size_t i = 0; i < baked.vectors.size(); ++i)
    ASSERT_NEAR(baked.near_vectors[i], baked.vectors[i], 4e-3);
}

// What a smooth sphere shows where a coarse one, whose normals are off, stands for it.
TEST(LeastSquares, FitWhatTheOriginalHad) {
  const TriangleMesh original = icosphere(4);
  TriangleMesh coarse = icosphere(1);
  for (std::size_t v = 0; v < coarse.vertexCount(); v += 3)
    coarse.normals[v] = float3((vec3(coarse.normals[v]) + Vec3(0.2, 0.1, 0)).normalized());
  TransferOptions options = fitted(Transport::kShadowed);
  const Transfer own = bake(coarse, options);
  options.original = &original;
  const Transfer to_original = bake(coarse, options);
  EXPECT_EQ(to_original.fit.strayed_samples, 0U);
  const TriangleMesh right = icosphere(1);
  // Normals that are wrong at single vertices are the roughest correction that there is, so some of it is left.
  EXPECT_LT(errorOnSphere(right, to_original.vectors, 3), 0.6 * errorOnSphere(right, own.vectors, 3));
}

TEST(LeastSquares, KeepTheirOwnWhereTheOriginalIsElsewhereOrFacesTheOtherWay) {
  const TriangleMesh sphere = icosphere(1);
  TransferOptions options = fitted(Transport::kShadowed);
  for (const TriangleMesh& original : {icosphere(2, 1, Vec3(50, 0, 0)), insideOut(icosphere(2))}) {
    options.original = &original;
    const Transfer baked = bake(sphere, options);
    EXPECT_EQ(baked.fit.strayed_samples, baked.fit.samples);
    EXPECT_EQ(baked.vectors, bake(sphere, atVertices(options)).vectors);
  }
}

TEST(LeastSquares, SameBytesWithAnyNumberOfThreads) {
  const TriangleMesh pair = twoSpheres();
  const TransferOptions options = fitted(Transport::kInterreflected);
  const Transfer all = bake(pair, options);
  for (const std::size_t threads : {1, 3}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_EQ(bake(pair, options).vectors, all.vectors);
  }
}

TEST(LeastSquares, AreNotForMatricesNorBouncesOffTheOriginal) {
  const TriangleMesh sphere = icosphere(1);
  TransferOptions matrices = fitted(Transport::kShadowed);
  matrices.glossy = Glossy::kMatrices;
  EXPECT_THROW(bake(sphere, matrices), std::invalid_argument);
  TransferOptions bounced = fitted(Transport::kInterreflected);
  bounced.original = &sphere;
  EXPECT_THROW(bake(sphere, bounced), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::transfer
