#include <gtest/gtest.h>

#include "tests/support/shapes.h"
#include "transport/ray_scene.h"

namespace bakelight::transport {
namespace {

TEST(RayScene, SingleRaysAreBlockedWithinTheirReachAlone) {
  const RayScene scene(tests::icosphere(3));
  int compared = 0;
  for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0.3, -0.8, 0.1), Vec3(-0.2, 0.1, 1)}) {
    const Vec3 towards = direction.normalized(), origin = -3 * towards;
    const Hit hit = scene.nearestHit(origin, towards);
    ASSERT_TRUE(hit.valid);
    EXPECT_NEAR(hit.distance, 2, 0.02);
    EXPECT_TRUE(scene.occluded(origin, towards));
    EXPECT_TRUE(scene.occluded(origin, towards, hit.distance * 1.0001f));
    EXPECT_FALSE(scene.occluded(origin, towards, hit.distance * 0.9999f));
    EXPECT_FALSE(scene.occluded(origin, -towards));
    EXPECT_TRUE(scene.occluded(Vec3::Zero(), towards));  // from inside too
    ++compared;
  }
  EXPECT_EQ(compared, 3);
}

}  // namespace
}  // namespace bakelight::transport
