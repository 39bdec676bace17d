#include "surface/metrics.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/support/shapes.h"
#include "tools/simplify/surface_words.h"

namespace bakelight::simplify {
namespace {

TEST(Metrics, AreaAndVolumeOfAFineSphereFarFromTheOrigin) {
  WorkingMesh mesh = workingMesh(tests::icosphere(5));
  for (Vec3& p : mesh.positions) p += Vec3(1e6, -1e6, 1e6);
  EXPECT_NEAR(area(mesh), 4 * std::numbers::pi, 0.01);
  EXPECT_NEAR(volume(mesh), 4 * std::numbers::pi / 3, 0.01);
}

TEST(Metrics, MinimumAngles) {
  const WorkingMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, std::sqrt(0.75), 0}},
                         {{0, 1, 2}, {0, 1, 3}}};
  EXPECT_NEAR(angleQuality(mesh).worst_min_angle_deg, 45, 1e-9);
  EXPECT_NEAR(angleQuality(mesh).mean_min_angle_deg, 52.5, 1e-9);
}

TEST(Metrics, DeviationOfShiftedSquaresIsTheShift) {
  const WorkingMesh low{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  WorkingMesh high = low;
  for (Vec3& p : high.positions) p.z() += 0.125;
  const Deviation result = deviation(SurfaceQuery(low), SurfaceQuery(high), 1000);
  EXPECT_NEAR(result.hausdorff, 0.125, 1e-12);
  EXPECT_NEAR(result.mean, 0.125, 1e-12);
}

TEST(Metrics, DeviationSeesWhatOnlyOneSideHas) {
  const WorkingMesh small{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  WorkingMesh with_far_part = small;
  for (const Vec3& p : {Vec3(0, 0, 3), Vec3(1, 0, 3), Vec3(0, 1, 3)}) with_far_part.positions.push_back(p);
  with_far_part.triangles.push_back({3, 4, 5});
  const SurfaceQuery a(small), b(with_far_part);
  EXPECT_NEAR(deviation(a, b, 100).hausdorff, 3, 1e-12);
  EXPECT_NEAR(deviation(b, a, 100).hausdorff, 3, 1e-12);
}

TEST(SurfaceQuery, FindsTheClosestPointOfASphere) {
  const SurfaceQuery query(workingMesh(tests::icosphere(3)));
  for (const Vec3& p : {Vec3(2, 0, 0), Vec3(0.3, -0.4, 0.1), Vec3(-5, 7, 9)}) {
    const ClosestPoint nearest = query.closest(p);
    // By brute force over all triangles' corners and the facets' chord error (0.9%).
    EXPECT_NEAR(nearest.distance, std::abs(p.norm() - 1), 0.01);
    EXPECT_NEAR((nearest.position - p).norm(), nearest.distance, 1e-12);
  }
}

TEST(SurfaceQuery, FacingSearchIgnoresTheFarSideOfAThinSheet) {
  const WorkingMesh sheet{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -0.01}, {1, 0, -0.01}, {0, 1, -0.01}},
                          {{0, 1, 2}, {3, 5, 4}}};
  const SurfaceQuery query(sheet);
  EXPECT_EQ(query.closest({0.2, 0.2, -0.02}).triangle, 1u);
  EXPECT_EQ(query.closestFacing({0.2, 0.2, -0.02}, {0, 0, 1}).triangle, 0u);
}

}  // namespace
}  // namespace bakelight::simplify
