#include "transport/vertex_fit.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <Eigen/Dense>

#include "tests/support/shapes.h"

namespace bakelight::transport {
namespace {

using namespace bakelight::tests;

// A function of the place, less what is given at the vertices (zero), at `count` samples a triangle.
using Sampled = double (*)(const Vec3&);
VertexFit fitOf(const TriangleMesh& mesh, Sampled sampled, double smoothness, int count = 8) {
  VertexFit fit(mesh, 1, smoothness);
  for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t) {
    const std::vector<FitSample> samples = samplesOn(mesh, t, count);
    std::vector<float> residuals;
    for (const FitSample& sample : samples) {
      Vec3 position = Vec3::Zero();
      for (int i = 0; i < 3; ++i) position += sample.weights[i] * vec3(mesh.positions[mesh.triangles[t][i]]);
      residuals.push_back(static_cast<float>(sampled(position)));
    }
    fit.add(t, fit.element(samples, residuals));
  }
  return fit;
}
double linear(const Vec3& x) {
  return 0.3 + x.dot(Vec3(1, -2, 0.5));
}
double curved(const Vec3& x) {
  return std::sin(3 * x.x()) + x.y() * x.y();
}
double nothing(const Vec3& /*x*/) {
  return 0;
}

TEST(VertexFit, SamplesStandForTheirTriangle) {
  const TriangleMesh mesh = icosphere(1);
  for (const int count : {1, 3, 8}) {
    double area = 0;
    for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t)
      for (const FitSample& sample : samplesOn(mesh, t, count)) {
        EXPECT_NEAR(sample.weights.sum(), 1, 1e-12);
        EXPECT_GE(sample.weights.minCoeff(), 0);
        area += sample.area;
      }
    EXPECT_NEAR(area, surfaceArea(mesh), 1e-6);
  }
  Vec3 mean = Vec3::Zero();
  const std::vector<FitSample> many = samplesOn(mesh, 0, 4096);
  for (const FitSample& sample : many) mean += sample.weights / static_cast<double>(many.size());
  EXPECT_LT((mean - Vec3::Constant(1.0 / 3)).norm(), 1e-3);
}

TEST(VertexFit, FindsWhatTheTrianglesCanShow) {
  const TriangleMesh mesh = icosphere(2);
  const auto found = fitOf(mesh, linear, 0).solve();
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v)
    ASSERT_NEAR(found.rows[v], linear(vec3(mesh.positions[v])), 1e-4) << v;
}

// The normal equations as they are written, solved densely.
TEST(VertexFit, SolvesTheNormalEquations) {
  const TriangleMesh mesh = icosphere(1);
  constexpr double kSmoothness = 0.02;
  const auto count = static_cast<Eigen::Index>(mesh.vertexCount());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(count);
  double before = 0;
  const auto forSamples = [&](const auto& take) {
    for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t)
      for (const FitSample& sample : samplesOn(mesh, t, 8)) {
        Vec3 position = Vec3::Zero();
        for (int i = 0; i < 3; ++i)
          position += sample.weights[i] * vec3(mesh.positions[mesh.triangles[t][i]]);
        take(mesh.triangles[t], sample, static_cast<double>(static_cast<float>(curved(position))));
      }
  };
  forSamples([&](const formats::Triangle& corners, const FitSample& sample, double value) {
    before += sample.area * value * value;
    for (int i = 0; i < 3; ++i) {
      right[corners[i]] += sample.area * sample.weights[i] * value;
      for (int j = 0; j < 3; ++j)
        matrix(corners[i], corners[j]) += sample.area * sample.weights[i] * sample.weights[j];
    }
  });
  for (const formats::Triangle& corners : mesh.triangles)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const auto edge = [&](int k) {
          return Vec3(vec3(mesh.positions[corners[(k + 2) % 3]]) -
                      vec3(mesh.positions[corners[(k + 1) % 3]]));
        };
        matrix(corners[i], corners[j]) += kSmoothness * edge(i).dot(edge(j));
      }
  const Eigen::VectorXd expected = matrix.ldlt().solve(right);
  const auto found = fitOf(mesh, curved, kSmoothness).solve();
  for (Eigen::Index v = 0; v < count; ++v) ASSERT_NEAR(found.rows[v], expected[v], 2e-5) << v;
  double after = 0;
  forSamples([&](const formats::Triangle& corners, const FitSample& sample, double value) {
    for (int i = 0; i < 3; ++i) value -= sample.weights[i] * expected[corners[i]];
    after += sample.area * value * value;
  });
  EXPECT_NEAR(found.squares_removed, before - after, 1e-4 * before);
}

TEST(VertexFit, LeavesWhatIsRightAndWhatNoSampleIsNear) {
  TriangleMesh mesh = icosphere(1);
  for (const float value : fitOf(mesh, nothing, 0.01).solve().rows) ASSERT_EQ(value, 0.0F);
  // An isolated vertex; triangles without area: an edge, a point, three points on a line.
  mesh.positions.push_back({3, 0, 0}), mesh.normals.push_back({1, 0, 0});
  mesh.triangles.push_back({0, 0, 1}), mesh.triangles.push_back({2, 2, 2});
  for (const float x : {5.0F, 6.0F, 7.0F})
    mesh.positions.push_back({x, 0, 0}), mesh.normals.push_back({0, 1, 0});
  mesh.triangles.push_back({43, 44, 45});
  const auto found = fitOf(mesh, curved, 0.01).solve();
  EXPECT_EQ(found.rows[42], 0.0F);
  for (std::size_t v = 43; v < 46; ++v) EXPECT_EQ(found.rows[v], 0.0F);
  for (const float value : found.rows) EXPECT_TRUE(std::isfinite(value));
}

TEST(VertexFit, TakesOneTriangleAndNone) {
  TriangleMesh one;
  one.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  one.normals.assign(3, {0, 0, 1});
  one.triangles = {{0, 1, 2}};
  const auto found = fitOf(one, linear, 0).solve();
  for (std::size_t v = 0; v < 3; ++v) EXPECT_NEAR(found.rows[v], linear(vec3(one.positions[v])), 1e-4);
  EXPECT_TRUE(fitOf({}, linear, 0).solve().rows.empty());
}

// Two halves of a square that share no vertex.
TEST(VertexFit, JoinsSeamsAndKeepsCreases) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.normals.assign(6, {0, 0, 1});
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  const auto stepped = [](const Vec3& x) { return x.x() > x.y() ? 1.0 : 0.0; };
  const VertexFit seam = fitOf(mesh, stepped, 0);
  EXPECT_EQ(seam.firstCopy(3), 0U);
  EXPECT_EQ(seam.firstCopy(4), 2U);
  mesh.normals[3] = mesh.normals[4] = mesh.normals[5] = {1, 0, 0};
  const auto creased = fitOf(mesh, stepped, 0).solve();
  for (std::size_t v = 0; v < 3; ++v) EXPECT_NEAR(creased.rows[v], 1, 1e-4);
  for (std::size_t v = 3; v < 6; ++v) EXPECT_NEAR(creased.rows[v], 0, 1e-4);
}

TEST(VertexFit, SameBytesWithAnyNumberOfThreads) {
  const TriangleMesh mesh = icosphere(4);
  const auto all = fitOf(mesh, curved, 0.01, 2).solve();
  for (const std::size_t threads : {1, 3}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_EQ(fitOf(mesh, curved, 0.01, 2).solve().rows, all.rows);
  }
}

}  // namespace
}  // namespace bakelight::transport
