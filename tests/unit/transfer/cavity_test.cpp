// The inside of a sphere with a part removed: under a uniform sky of radiance 1 its radiosity is the same
// everywhere,
//   B = ρ π f / (1 − ρ (1 − f)),  f the open fraction,
// which plain bounces reach ever more slowly as ρ (1 − f) → 1.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "tests/support/spherical_cavity.h"
#include "tests/unit/transfer/bake.h"

namespace bakelight::transfer {
namespace {

using namespace bakelight::tests;

constexpr double kPi = std::numbers::pi;

// B of a vertex from its baked vector, under a uniform sky of 1.
double radiosity(const Transfer& baked, int order, std::size_t vertex, double albedo) {
  return albedo * kPi * baked.vectors[vertex * static_cast<std::size_t>(order) * order] * std::sqrt(4 * kPi);
}

struct CavityCase {
  double open_fraction, albedo;
};

class SphericalCavity : public testing::TestWithParam<CavityCase> {};

TEST_P(SphericalCavity, RadiosityIsTheClosedForm) {
  const auto [nominal_fraction, albedo] = GetParam();
  const Cavity cavity = sphericalCavity(nominal_fraction, 3);
  const double f = cavity.mean_open_fraction;
  ASSERT_NEAR(f, nominal_fraction, 0.15 * nominal_fraction);  // the mesh is the intended one

  const int order = 1;
  const std::vector<Float3> albedos = {
      Float3{static_cast<float>(albedo), static_cast<float>(albedo), static_cast<float>(albedo)}};
  const Transfer baked = bake(cavity.mesh,
                              {.order = order,
                               .directions = nominal_fraction > 0.1 ? 8192 : 65536,
                               .transport = Transport::kInterreflected},
                              albedos);

  const double expected = albedo * kPi * f / (1 - albedo * (1 - f));
  double mean = 0, squares = 0;
  int compared = 0;
  for (std::size_t v = 0; v < cavity.mesh.vertexCount(); ++v) {
    if (cavity.open_fraction[v] < 0) continue;
    const double ratio = radiosity(baked, order, v, albedo) / expected;
    mean += ratio, squares += (ratio - 1) * (ratio - 1);
    ++compared;
  }
  ASSERT_GT(compared, 400);
  mean /= compared;
  const double rms = std::sqrt(squares / compared);
  RecordProperty("passes", static_cast<int>(baked.interreflection.added_energy.size()));
  RecordProperty("solver", baked.interreflection.solver);
  std::printf(
      "f %.5f (nominal %.2f) albedo %.3f: mean error %+.4f%%, rms %.4f%%; %zu passes, %s, bound %.1e\n", f,
      nominal_fraction, albedo, 100 * (mean - 1), 100 * rms, baked.interreflection.added_energy.size(),
      baked.interreflection.solver.c_str(), baked.interreflection.error_bound);
  EXPECT_NEAR(mean, 1, 0.01);
  EXPECT_LT(rms, 0.01);
  EXPECT_TRUE(baked.interreflection.converged);
  EXPECT_LE(baked.interreflection.added_energy.size(), 40u);
}

INSTANTIATE_TEST_SUITE_P(Fractions, SphericalCavity,
                         testing::Values(CavityCase{0.25, 0.5}, CavityCase{0.25, 0.9}, CavityCase{0.25, 0.99},
                                         CavityCase{0.25, 0.999}, CavityCase{0.01, 0.5},
                                         CavityCase{0.01, 0.9}, CavityCase{0.01, 0.99},
                                         CavityCase{0.01, 0.999}));

// Band 0 is that of the closed form whatever bands come along.
class CavityOrder : public testing::TestWithParam<int> {};

TEST_P(CavityOrder, RadiosityIsTheClosedForm) {
  static const Cavity cavity = sphericalCavity(0.25, 2);
  const float albedo = 0.99f;
  const std::vector<Float3> albedos = {{albedo, albedo, albedo}};
  const Transfer baked =
      bake(cavity.mesh, {.order = GetParam(), .directions = 4096, .transport = Transport::kInterreflected},
           albedos);
  const double f = cavity.mean_open_fraction, expected = albedo * kPi * f / (1 - albedo * (1 - f));
  int compared = 0;
  for (std::size_t v = 0; v < cavity.mesh.vertexCount(); ++v) {
    if (cavity.open_fraction[v] < 0) continue;
    EXPECT_NEAR(radiosity(baked, GetParam(), v, albedo) / expected, 1, 0.01) << "vertex " << v;
    ++compared;
  }
  EXPECT_GT(compared, 60);
}

INSTANTIATE_TEST_SUITE_P(Orders, CavityOrder, testing::Range(1, 11));

// The accelerated solve and a thousand and a half plain bounces agree.
TEST(Cavity, AcceleratedSolveEqualsManyBounces) {
  const Cavity cavity = sphericalCavity(0.01, 3);
  const std::vector<Float3> albedo = {{0.999f, 0.9f, 0.5f}};
  TransferOptions options{.order = 3, .directions = 4096, .transport = Transport::kInterreflected};
  options.interreflection.threshold = 1e-5;
  const Transfer fast = bake(cavity.mesh, options, albedo);
  options.interreflection.bounces = 1500;
  const Transfer slow = bake(cavity.mesh, options, albedo);
  EXPECT_EQ(fast.interreflection.solver, "gmres");
  EXPECT_EQ(slow.interreflection.solver, "passes");
  EXPECT_LT(fast.interreflection.added_energy.size(), 40u);
  ASSERT_EQ(slow.interreflection.added_energy.size(), 1500u);
  ASSERT_EQ(fast.vectors.size(), slow.vectors.size());
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < fast.vectors.size(); ++i) {
    difference += std::pow(fast.vectors[i] - slow.vectors[i], 2);
    size += std::pow(slow.vectors[i], 2);
  }
  EXPECT_LT(std::sqrt(difference / size), 1e-4);
}

// Few bounces in a bright cavity are not passed over in silence.
TEST(Cavity, TruncationIsReported) {
  const Cavity cavity = sphericalCavity(0.01, 2);
  const std::vector<Float3> albedo = {{0.99f, 0.99f, 0.99f}};
  TransferOptions options{.order = 1, .directions = 4096, .transport = Transport::kInterreflected};
  options.interreflection.bounces = 3;
  const Transfer baked = bake(cavity.mesh, options, albedo);
  EXPECT_EQ(baked.interreflection.added_energy.size(), 3u);
  EXPECT_FALSE(baked.interreflection.converged);
  EXPECT_GT(baked.interreflection.error_bound, 0.5);
}

TEST(Cavity, ClosedIsDarkWhateverItsAlbedo) {
  const TriangleMesh closed = insideOut(icosphere(3));
  for (const float albedo : {0.5f, 0.99f, 1.0f}) {
    const std::vector<Float3> albedos = {{albedo, albedo, albedo}};
    const Transfer baked =
        bake(closed, {.order = 3, .directions = 1024, .transport = Transport::kInterreflected}, albedos);
    EXPECT_TRUE(baked.interreflection.converged);
    for (const float value : baked.vectors) ASSERT_EQ(value, 0);
  }
}

}  // namespace
}  // namespace bakelight::transfer
