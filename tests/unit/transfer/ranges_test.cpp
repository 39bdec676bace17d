// Ranges of points traced one by one and put together are the whole, to the bit.
#include <gtest/gtest.h>

#include "tests/support/spherical_cavity.h"
#include "tests/unit/transfer/bake.h"
#include "tools/transfer/solve_phase.h"
#include "tools/transfer/trace_phase.h"

namespace bakelight::transfer {
namespace {

using namespace bakelight::tests;

// A hollow with a ball in it, and another that sees the hollow's back.
TriangleMesh hollowAndBalls() {
  TriangleMesh scene = sphericalCavity(0.4, 2).mesh;
  append(scene, icosphere(2, 0.4, Vec3(0, -0.3, 0)));
  append(scene, icosphere(1, 0.5, Vec3(1.6, 0, 0)));
  return scene;
}

struct Case {
  const char* name;
  TransferOptions options;
};

class Ranges : public testing::TestWithParam<Case> {};

TEST_P(Ranges, PutTogetherAreTheWhole) {
  const TriangleMesh mesh = hollowAndBalls();
  const std::vector<Float3> albedo = {{0.9F, 0.6F, 0.3F}};
  const auto setup = [&] { return BakeSetup(mesh, albedo, GetParam().options); };
  stage::Progress silent(stage::ProgressStyle::kNone, "", 0, "");
  const std::size_t count = mesh.vertexCount();
  ASSERT_GT(count, 250U);
  TracedPoints whole = traceFronts(setup(), {0, count}, silent);
  TracedPoints parts = traceFronts(setup(), {0, 37}, silent);
  for (const PointRange& range : {PointRange{37, 37}, PointRange{37, 200}, PointRange{200, count}})
    parts.append(traceFronts(setup(), range, silent));

  EXPECT_EQ(parts.vectors, whole.vectors);
  EXPECT_EQ(parts.near_vectors, whole.near_vectors);
  EXPECT_EQ(parts.visibility, whole.visibility);
  EXPECT_EQ(parts.blocked_rays, whole.blocked_rays);
  ASSERT_EQ(parts.figures.size(), count);
  ASSERT_EQ(parts.seen.rowCount(), whole.seen.rowCount());
  for (std::size_t v = 0; v < whole.seen.rowCount(); ++v)
    ASSERT_EQ(parts.seen.row(v), whole.seen.row(v)) << v;
  const Transfer of_parts = solve(setup(), std::move(parts)), of_whole = solve(setup(), std::move(whole));
  EXPECT_EQ(of_parts.vectors, of_whole.vectors);
  EXPECT_EQ(of_parts.near_vectors, of_whole.near_vectors);
  EXPECT_EQ(of_parts.matrices, of_whole.matrices);
  EXPECT_EQ(of_parts.visibility, of_whole.visibility);
  EXPECT_EQ(of_parts.back_points > 0, setup().interreflected());
  EXPECT_EQ(of_parts.rays, of_whole.rays);
  EXPECT_EQ(of_parts.vectors, bake(mesh, GetParam().options, albedo).vectors);
}

TransferOptions bounced(Glossy glossy, double memory) {
  return {.order = 3,
          .directions = 512,
          .transport = Transport::kInterreflected,
          .glossy = glossy,
          .row_order = 2,
          .sphere_radius = 1.5,
          .memory = memory};
}
INSTANTIATE_TEST_SUITE_P(
    , Ranges,
    testing::Values(Case{"Shadowed",
                         {.order = 2, .directions = 512, .glossy = Glossy::kVisibility, .row_order = 2}},
                    Case{"Bounced", bounced(Glossy::kMatrices, 0)},
                    Case{"WithinLittleMemory", bounced(Glossy::kNone, 0.001)}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace bakelight::transfer
