#include "tools/transfer/outliers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/shapes.h"
#include "tests/unit/transfer/bake.h"
#include "tools/transfer/shadow_pass.h"
#include "transport/sh.h"

namespace bakelight::transfer {
namespace {

using namespace bakelight::tests;

constexpr int kCells = 24;

std::uint32_t floorVertex(int x, int y) {
  return static_cast<std::uint32_t>(y * (kCells + 1) + x);
}
const std::uint32_t kHooded = floorVertex(12, 12);

// A floor of cells of size 1, facing +Y.
TriangleMesh floorOfCells() {
  TriangleMesh mesh;
  for (int y = 0; y <= kCells; ++y)
    for (int x = 0; x <= kCells; ++x) {
      mesh.positions.push_back({static_cast<float>(x), 0, static_cast<float>(-y)});
      mesh.normals.push_back({0, 1, 0});
    }
  for (int y = 0; y < kCells; ++y)
    for (int x = 0; x < kCells; ++x) {
      mesh.triangles.push_back({floorVertex(x, y), floorVertex(x + 1, y), floorVertex(x + 1, y + 1)});
      mesh.triangles.push_back({floorVertex(x, y), floorVertex(x + 1, y + 1), floorVertex(x, y + 1)});
    }
  return mesh;
}

// The same with a tent over one vertex, a tenth of a cell wide, two-sided and not quite closed at its foot:
// of the vertex's point it takes nearly all light, of its area next to none.
TriangleMesh floorWithHood() {
  TriangleMesh scene = floorOfCells();
  const Float3& foot = scene.positions[kHooded];
  TriangleMesh hood;
  hood.positions.push_back({foot[0], 0.1f, foot[2]});
  for (int k = 0; k < 8; ++k) {
    const double angle = 2 * std::numbers::pi * k / 8;
    hood.positions.push_back({foot[0] + 0.05f * static_cast<float>(std::cos(angle)), 0.01f,
                              foot[2] - 0.05f * static_cast<float>(std::sin(angle))});
  }
  for (std::uint32_t k = 0; k < 8; ++k) hood.triangles.push_back({0, k + 1, (k + 1) % 8 + 1});
  for (const Float3& position : hood.positions) {
    const Vec3 outwards = vec3(position) - vec3(foot);
    hood.normals.push_back(float3(outwards.normalized()));
  }
  append(scene, hood);
  append(scene, insideOut(hood));
  return scene;
}

double openShare(const Transfer& baked, std::size_t row_size, std::size_t vertex) {
  return baked.vectors[vertex * row_size] * std::sqrt(4 * std::numbers::pi);
}

TransferOptions finely(int order) {
  return {.order = order, .directions = 1024, .bias = 1e-5};
}

TEST(Outliers, AVertexUnderATinyHoodIsLitAsItsAreaIs) {
  const TriangleMesh scene = floorWithHood();
  const Transfer baked = bake(scene, finely(4));
  EXPECT_EQ(baked.resampled_vertices, 1u);
  EXPECT_GT(openShare(baked, 16, kHooded), 0.9);

  // All others are what their points say, to the bit.
  const transport::RayScene rays(scene);
  ShadowOptions options;
  options.order = 4;
  const ShadowPass pass(scene, rays, options, 1024);
  ShadowPass::Workspace work(pass);
  const std::vector<SurfacePoint> points = frontPoints(scene, 1e-5);
  const auto sides = sidesFromBehind(scene);
  std::vector<float> vector(16);
  for (std::size_t v = 0; v < floorOfCells().vertexCount(); ++v) {
    pass.trace(points[v], sides, {vector, {}, {}}, work);
    const std::vector<float> row(&baked.vectors[16 * v], &baked.vectors[16 * v] + 16);
    if (v == kHooded)
      EXPECT_LT(vector[0] * std::sqrt(4 * std::numbers::pi), 0.3);
    else
      ASSERT_EQ(row, vector) << "vertex " << v;
  }
}

// Which vertices those are does not depend on the order of the bake.
TEST(Outliers, AnyOrderBeginsWithTheLowerOne) {
  const TriangleMesh scene = floorWithHood();
  const Transfer five = bake(scene, finely(5));
  for (int order = 1; order < 5; ++order) {
    const Transfer lower = bake(scene, finely(order));
    const auto size = static_cast<std::size_t>(order) * order;
    ASSERT_EQ(lower.resampled_vertices, 1u) << "order " << order;
    for (std::size_t v = 0; v < scene.vertexCount(); ++v)
      for (std::size_t i = 0; i < size; ++i)
        ASSERT_EQ(lower.vectors[v * size + i], five.vectors[v * 25 + i])
            << "order " << order << " vertex " << v;
  }
}

// Each table that a bake can have: the hooded vertex is like the one three cells on.
TEST(Outliers, AllTablesAreOfTheArea) {
  const TriangleMesh scene = floorWithHood();
  const std::uint32_t open = floorVertex(15, 12);
  const std::vector<Float3> albedo = {{0.5f, 0.5f, 0.5f}};
  const auto expectAlike = [&](std::span<const float> table, const std::string& what) {
    ASSERT_FALSE(table.empty()) << what;
    const std::size_t size = table.size() / scene.vertexCount();
    double difference = 0, length = 0;
    for (std::size_t i = 0; i < size; ++i) {
      difference += std::pow(table[kHooded * size + i] - table[open * size + i], 2);
      length += std::pow(table[open * size + i], 2);
    }
    EXPECT_LT(std::sqrt(difference / length), 0.1) << what;
  };
  for (const Transport transport : {Transport::kShadowed, Transport::kInterreflected}) {
    TransferOptions options = finely(3);
    options.transport = transport;
    options.glossy = Glossy::kMatrices;
    options.row_order = 3;
    options.sphere_radius = 3;
    const Transfer baked = bake(scene, options, albedo);
    EXPECT_EQ(baked.resampled_vertices, 1u);
    expectAlike(baked.vectors, "vectors");
    expectAlike(baked.near_vectors, "near vectors");
    expectAlike(baked.matrices, "matrices");
  }
  TransferOptions options = finely(3);
  options.glossy = Glossy::kVisibility;
  expectAlike(bake(scene, options).visibility, "visibility");
}

// The light that bounces off the hood comes to the area, not to the point alone: white surfaces under a
// uniform sky stay white.
TEST(Outliers, WhiteFurnace) {
  const TriangleMesh scene = floorWithHood();
  const std::vector<Float3> white = {{1, 1, 1}};
  TransferOptions options = finely(1);
  options.transport = Transport::kInterreflected;
  options.interreflection.threshold = 1e-5;
  const Transfer baked = bake(scene, options, white);
  EXPECT_EQ(baked.resampled_vertices, 1u);
  for (std::size_t v = 0; v < scene.vertexCount(); ++v)
    EXPECT_NEAR(openShare(baked, 1, v), 1, 2e-3) << "vertex " << v;
}

TEST(Outliers, ShadowsThatNeighborsShareAreNone) {
  // A ball on the floor: dark below, and darker towards the point of contact.
  TriangleMesh scene = floorOfCells();
  append(scene, icosphere(3, 4, Vec3(12, 4.5, -12)));
  EXPECT_EQ(bake(scene, finely(4)).resampled_vertices, 0u);
}

TEST(Outliers, SamplesFollowTheHatFunction) {
  const TriangleMesh mesh = icosphere(1);
  const IncidentTriangles incident(mesh);
  constexpr int kSamples = 20000;
  for (const std::uint32_t vertex : {0u, 20u}) {
    // Mean position by the closed form: in each triangle half the vertex, a quarter each other corner.
    Vec3 expected = Vec3::Zero(), mean = Vec3::Zero();
    double area = 0;
    for (const std::uint32_t t : incident.of(vertex)) {
      const auto& [a, b, c] = mesh.triangles[t];
      const Vec3 pa = vec3(mesh.positions[a]), pb = vec3(mesh.positions[b]), pc = vec3(mesh.positions[c]);
      const double own = (pb - pa).cross(pc - pa).norm() / 2;
      expected += own * ((pa + pb + pc) / 4 + vec3(mesh.positions[vertex]) / 4);
      area += own;
    }
    for (const SurfacePoint& sample : hatSamples(mesh, incident, vertex, 0, kSamples)) {
      mean += vec3(sample.origin) / kSamples;
      ASSERT_NEAR(vec3(sample.normal).norm(), 1, 1e-6);
    }
    EXPECT_LT((mean - expected / area).norm(), 1e-3) << "vertex " << vertex;
  }
  TriangleMesh lone;
  lone.positions = {{0, 0, 0}};
  lone.normals = {{0, 1, 0}};
  EXPECT_TRUE(hatSamples(lone, IncidentTriangles(lone), 0, 0, 4).empty());
}

// Blocked and visible share add up to one, whatever two queries of the ray tracer say of an edge.
TEST(ShadowPass, GrazingRaysPass) {
  TriangleMesh pair = icosphere(3);
  append(pair, icosphere(3, 0.7, Vec3(1.8, 0.3, 0)));
  const transport::RayScene rays(pair);
  ShadowOptions options;
  options.order = 2;
  options.record_hits = true;
  const ShadowPass pass(pair, rays, options, 1024);
  ShadowPass::Workspace work(pass);
  const auto points = frontPoints(pair, 1e-4);
  const auto sides = sidesFromBehind(pair);
  std::vector<float> vector(9);
  std::size_t partly = 0;
  for (const SurfacePoint& point : points) {
    const TracedPoint traced = pass.trace(point, sides, {vector, {}, {}}, work);
    double seen = vector[0] * std::sqrt(4 * std::numbers::pi);
    for (const transport::SeenVertex& vertex : traced.seen) seen += vertex.weight;
    EXPECT_NEAR(seen, 1, 1e-5);
    partly += traced.seen.empty() ? 0 : 1;
    // As if the second query had missed every other ray.
    const std::vector<std::uint32_t> directions = work.blocked_directions;
    for (std::size_t k = 0; k < directions.size(); k += 2) work.hits.blocked[k] = 0;
    letGrazingRaysPass(work);
    ASSERT_EQ(work.blocked_directions.size(), directions.size() / 2);
    ASSERT_EQ(work.blocked_cosines.size(), directions.size() / 2);
    for (std::size_t k = 0; k < directions.size() / 2; ++k) {
      EXPECT_EQ(work.blocked_directions[k], directions[2 * k + 1]);
      EXPECT_EQ(work.hits.blocked[k], 1);
    }
    EXPECT_EQ(std::count(work.blocked.begin(),
                         work.blocked.begin() + static_cast<std::ptrdiff_t>(work.hemisphere.count), 1),
              static_cast<std::ptrdiff_t>(directions.size() / 2));
  }
  EXPECT_GT(partly, 100u);
}

}  // namespace
}  // namespace bakelight::transfer
