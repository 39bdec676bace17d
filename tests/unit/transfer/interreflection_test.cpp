#include "transport/interreflection.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "tests/support/shapes.h"
#include "tests/unit/transfer/bake.h"
#include "transport/sh.h"

namespace bakelight::transfer {
namespace {

using namespace bakelight::tests;

constexpr double kPi = std::numbers::pi;

TransferOptions interreflected(int order, int directions = 4096) {
  return {.order = order, .directions = directions, .transport = Transport::kInterreflected};
}
TriangleMesh twoSpheres() {
  TriangleMesh pair = icosphere(3);
  append(pair, icosphere(3, 0.7, Vec3(1.8, 0.3, 0)));
  return pair;
}
// Square in the plane through `center` that faces `normal`, `cells` × `cells` quads.
TriangleMesh plate(const Vec3& center, const Vec3& x, const Vec3& y, int cells) {
  TriangleMesh mesh;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      mesh.positions.push_back(float3(center + (2.0 * i / cells - 1) * x + (2.0 * j / cells - 1) * y));
      mesh.normals.push_back(float3(x.cross(y).normalized()));
    }
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const auto at = static_cast<std::uint32_t>(j * (cells + 1) + i);
      const auto up = at + static_cast<std::uint32_t>(cells) + 1;
      mesh.triangles.push_back({at, at + 1, up + 1});
      mesh.triangles.push_back({at, up + 1, up});
    }
  return mesh;
}

TEST(Interreflection, BlackSurfacesSendNothingOn) {
  const std::vector<Float3> black = {{0, 0, 0}};
  const Transfer baked = bake(twoSpheres(), interreflected(4), black);
  const Transfer shadowed = bake(twoSpheres(), {.order = 4, .transport = Transport::kShadowed});
  ASSERT_EQ(baked.vectors.size(), shadowed.vectors.size());
  double worst = 0;
  for (std::size_t i = 0; i < baked.vectors.size(); ++i)
    worst = std::max<double>(worst, std::abs(baked.vectors[i] - shadowed.vectors[i]));
  // Nearest hits and any hits are two code paths of the ray tracer: a grazing ray may differ.
  EXPECT_LT(worst, 2e-3);
}

TEST(Interreflection, ConvexBodyHasNone) {
  const TriangleMesh sphere = icosphere(3);
  const Transfer baked = bake(sphere, interreflected(5));
  EXPECT_EQ(baked.vectors, bake(sphere, {.order = 5, .transport = Transport::kUnshadowed}).vectors);
  EXPECT_EQ(baked.form_factors, 0u);
}

// Furnace: white surfaces under a uniform sky of 1 have radiance 1 wherever light can get to.
TEST(Interreflection, WhiteFurnace) {
  const std::vector<Float3> white = {{1, 1, 1}};
  TransferOptions options = interreflected(2);
  options.interreflection.threshold = 1e-4;
  const Transfer baked = bake(twoSpheres(), options, white);
  EXPECT_GT(baked.form_factors, 1000u);
  for (std::size_t v = 0; v < baked.vectors.size() / 4; ++v)
    EXPECT_NEAR(baked.vectors[4 * v] * std::sqrt(4 * kPi), 1, 2e-3) << "vertex " << v;
}

// Coloured surfaces: three channels, each of which is the solution for its own albedo.
TEST(Interreflection, ChannelsAreIndependent) {
  const std::vector<Float3> colored = {{0.9f, 0.5f, 0.1f}}, gray = {{0.5f, 0.5f, 0.5f}};
  TransferOptions options = interreflected(3, 2048);
  options.interreflection.threshold = 1e-5;
  const Transfer rgb = bake(twoSpheres(), options, colored), one = bake(twoSpheres(), options, gray);
  ASSERT_EQ(rgb.channels, 3);
  ASSERT_EQ(one.channels, 1);
  ASSERT_EQ(rgb.vectors.size(), 3 * one.vectors.size());
  for (std::size_t v = 0; v < one.vectors.size() / 9; ++v)
    for (std::size_t i = 0; i < 9; ++i)
      EXPECT_NEAR(rgb.vectors[27 * v + 9 + i], one.vectors[9 * v + i], 2e-5);
}

// Two large parallel plates that face each other at distance d: at their middle each sees the other's share
// F = 2 (Lambert, coaxial squares from the centre point); one bounce adds F ρ × the light that reaches the
// other.
TEST(Interreflection, AVertexAlbedoColorsItsNeighbor) {
  TriangleMesh corner = plate({0, 0, 0}, {1, 0, 0}, {0, 0, -1}, 8);  // floor, facing +Y
  const std::size_t floor_count = corner.vertexCount();
  append(corner, plate({-1, 1, 0}, {0, 0, 1}, {0, -1, 0}, 8));  // wall, facing +X
  ASSERT_NEAR(corner.normals.back()[0], 1, 1e-6);
  std::vector<Float3> albedo(corner.vertexCount(), Float3{0, 0, 0});
  for (std::size_t v = floor_count; v < albedo.size(); ++v) albedo[v] = {1, 0, 0};
  const Transfer baked = bake(corner, interreflected(2), albedo);
  ASSERT_EQ(baked.channels, 3);
  for (std::size_t v = 0; v < floor_count; ++v) {
    const float* row = &baked.vectors[v * 12];
    EXPECT_GT(row[0], row[4] + 0.005) << "red light from the wall, floor vertex " << v;
    EXPECT_EQ(row[4], row[8]);
  }
}

// An open sheet above a floor, lit from below by the floor: the underside of the sheet sends light back
// although its front faces up, because backs are points of their own.
TEST(Interreflection, BacksOfOpenSheetsAreLitFromTheirOwnSide) {
  TriangleMesh scene = plate({0, 0, 0}, {4, 0, 0}, {0, 0, -4}, 16);
  const std::size_t floor_count = scene.vertexCount();
  append(scene, plate({0, 1, 0}, {1, 0, 0}, {0, 0, -1}, 8));  // faces up: the floor sees its back
  TriangleMesh doubled = scene;                               // the same with an underside of its own
  append(doubled, insideOut(plate({0, 1, 0}, {1, 0, 0}, {0, 0, -1}, 8)));
  const std::vector<Float3> albedo = {{0.8f, 0.8f, 0.8f}};
  const Transfer single = bake(scene, interreflected(2, 8192), albedo);
  const Transfer both = bake(doubled, interreflected(2, 8192), albedo);
  const Transfer direct = bake(scene, {.order = 2, .directions = 8192});
  EXPECT_GT(single.back_points, 60u);
  const std::size_t under = floor_count / 2;  // the floor's middle
  EXPECT_NEAR(single.vectors[under * 4], both.vectors[under * 4], 2e-3);
  EXPECT_GT(single.vectors[under * 4], direct.vectors[under * 4] + 0.01);
}

TEST(Interreflection, BuriedVerticesDoNotDarkenWhatSeesThem) {
  // A slab half sunk into another: the sunk vertices are corners of triangles that reach out.
  TriangleMesh pair = icosphere(3);
  append(pair, icosphere(1, 0.8, Vec3(0.9, 0, 0)));  // coarse: long triangles from inside to outside
  const std::vector<Float3> white = {{1, 1, 1}};
  const Transfer baked = bake(pair, interreflected(1), white);
  ASSERT_GT(baked.buried_vertices, 0u);
  ASSERT_EQ(baked.filled_vertices, baked.buried_vertices);
  for (const float value : baked.vectors) EXPECT_GT(value * std::sqrt(4 * kPi), 0.8);
}

TEST(Interreflection, SameBytesWithAnyNumberOfThreads) {
  const std::vector<Float3> albedo = {{0.9f, 0.95f, 0.99f}};
  const Transfer many = bake(twoSpheres(), interreflected(4, 1024), albedo);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Transfer single = bake(twoSpheres(), interreflected(4, 1024), albedo);
  EXPECT_EQ(single.vectors, many.vectors);
  EXPECT_EQ(single.interreflection.added_energy, many.interreflection.added_energy);
}

TEST(Interreflection, EnergyFallsFromPassToPass) {
  const std::vector<Float3> albedo = {{0.7f, 0.7f, 0.7f}};
  const Transfer baked = bake(twoSpheres(), interreflected(3), albedo);
  const auto& energy = baked.interreflection.added_energy;
  ASSERT_GE(energy.size(), 2u);
  for (std::size_t b = 1; b < energy.size(); ++b) EXPECT_LT(energy[b], energy[b - 1]);
  EXPECT_LE(baked.interreflection.error_bound, 1e-3);
}

}  // namespace
}  // namespace bakelight::transfer
