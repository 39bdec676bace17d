#include "tools/transfer/memory_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/spherical_cavity.h"
#include "tests/unit/transfer/bake.h"

namespace bakelight::transfer {
namespace {

using namespace bakelight::tests;

TriangleMesh twoSpheres(int subdivisions) {
  TriangleMesh pair = icosphere(subdivisions);
  append(pair, icosphere(subdivisions, 0.7, Vec3(1.8, 0.3, 0)));
  return pair;
}

double relativeDifference(const std::vector<float>& values, const std::vector<float>& reference) {
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    difference += std::pow(values[i] - reference[i], 2);
    size += std::pow(reference[i], 2);
  }
  return std::sqrt(difference / size);
}

TEST(MemoryPlan, TwoKilobytesAVertexAndTwoGigabytesAtLeast) {
  EXPECT_EQ(defaultMemory(0), 2'000'000'000U);
  EXPECT_EQ(defaultMemory(1'000'000), 2'000'000'000U);
  EXPECT_EQ(defaultMemory(5'000'000), 10'000'000'000U);
}

// Colours and near field one after the other give what all at once do.
TEST(MemoryPlan, PartsOfTheColumnsAreSolvedAsAllAtOnce) {
  const std::vector<Float3> albedo = {{0.9F, 0.6F, 0.3F}};
  TransferOptions options = {
      .order = 10, .directions = 64, .transport = Transport::kInterreflected, .sphere_radius = 1.5};
  options.interreflection.bounces = 3;
  const Transfer at_once = bake(twoSpheres(2), options, albedo);
  ASSERT_TRUE(at_once.exact_shares);
  EXPECT_EQ(at_once.interreflection_parts, 1);
  options.memory = 1.001e-9 * static_cast<double>(at_once.memory_expected);
  const Transfer in_parts = bake(twoSpheres(2), options, albedo);
  ASSERT_TRUE(in_parts.exact_shares);
  EXPECT_GT(in_parts.interreflection_parts, 1);
  EXPECT_EQ(in_parts.vectors, at_once.vectors);
  EXPECT_EQ(in_parts.near_vectors, at_once.near_vectors);
  const auto& energy = in_parts.interreflection.added_energy;
  ASSERT_EQ(energy.size(), 3U);
  for (std::size_t i = 0; i < energy.size(); ++i)
    EXPECT_NEAR(energy[i], at_once.interreflection.added_energy[i], 1e-6);
}

// White surfaces under a uniform sky of 1 have radiance 1 however few shares stand for what they see.
TEST(MemoryPlan, LittleMemoryLosesNoLight) {
  const TriangleMesh mesh = sphericalCavity(0.4, 4).mesh;
  const std::vector<Float3> white = {{1, 1, 1}};
  TransferOptions options = {.order = 3, .directions = 2048, .transport = Transport::kInterreflected};
  options.interreflection.threshold = 1e-4;
  const Transfer exact = bake(mesh, options, white);
  options.memory = 1e-3;
  const Transfer sampled = bake(mesh, options, white);
  ASSERT_TRUE(exact.exact_shares);
  ASSERT_FALSE(sampled.exact_shares);
  EXPECT_GT(sampled.share_threshold, 0);
  EXPECT_LT(sampled.form_factor_bytes, exact.form_factor_bytes / 10);
  EXPECT_GT(sampled.memory_expected, sampled.memory_limit);
  for (std::size_t v = 0; v < sampled.vectors.size() / 9; ++v)
    EXPECT_NEAR(sampled.vectors[9 * v] * std::sqrt(4 * std::numbers::pi), 1, 3e-3) << "vertex " << v;
  const double difference = relativeDifference(sampled.vectors, exact.vectors);
  EXPECT_LT(difference, 0.1);
  EXPECT_GT(difference, 1e-6);
}

TEST(MemoryPlan, AStiffCavityIsSolvedWithinLittleMemory) {
  const Cavity cavity = sphericalCavity(0.05, 3);
  TransferOptions options = {.order = 1, .directions = 2048, .transport = Transport::kInterreflected};
  const std::vector<Float3> albedo = {{0.99F, 0.99F, 0.99F}};
  const Transfer exact = bake(cavity.mesh, options, albedo);
  options.memory = 1e-3;
  const Transfer little = bake(cavity.mesh, options, albedo);
  EXPECT_EQ(little.interreflection.solver, "gmres");
  EXPECT_TRUE(little.interreflection.converged);
  EXPECT_LT(relativeDifference(little.vectors, exact.vectors), 1e-2);
}

}  // namespace
}  // namespace bakelight::transfer
