// Rays from cell to cell of a periodic surface against the same surface laid out as triangles.
#include "transport/periodic_ray_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "transport/random.h"

namespace bakelight::transport {
namespace {

using formats::TriangleMesh;

constexpr double kPi = std::numbers::pi;

double hashedUnit(std::uint64_t element) {
  return static_cast<double>(scrambled(element) >> 11) * 0x1p-53;
}

// Waves of the given depth, 1 × 0.5, with a square hole where `holes`.
TriangleMesh waves(double depth, bool holes) {
  constexpr int kAcross = 16, kUp = 8;
  TriangleMesh mesh;
  for (int y = 0; y <= kUp; ++y)
    for (int x = 0; x <= kAcross; ++x) {
      const double z = depth / 2 * std::sin(2 * kPi * x / kAcross) * std::cos(2 * kPi * y / kUp);
      mesh.positions.push_back(
          {static_cast<float>(x) / kAcross, 0.5F * static_cast<float>(y) / kUp, static_cast<float>(z)});
    }
  for (std::uint32_t y = 0; y < kUp; ++y)
    for (std::uint32_t x = 0; x < kAcross; ++x) {
      if (holes && x >= 4 && x < 8 && y >= 2 && y < 5) continue;
      const std::uint32_t a = y * (kAcross + 1) + x, b = a + 1, d = a + kAcross + 1, c = d + 1;
      mesh.triangles.insert(mesh.triangles.end(), {{a, b, c}, {a, c, d}});
    }
  return mesh;
}

TriangleMesh laidOut(const TriangleMesh& mesh, int reach_x, int reach_y) {
  TriangleMesh all;
  for (int j = -reach_y; j <= reach_y; ++j)
    for (int i = -reach_x; i <= reach_x; ++i) {
      const auto base = static_cast<std::uint32_t>(all.vertexCount());
      for (const Float3& p : mesh.positions)
        all.positions.push_back({p[0] + static_cast<float>(i), p[1] + 0.5F * static_cast<float>(j), p[2]});
      for (const auto& t : mesh.triangles) all.triangles.push_back({base + t[0], base + t[1], base + t[2]});
    }
  return all;
}

// Downwards and upwards, up to 80° from the vertical, from within and from outside.
FreeRays someRays(double depth, std::size_t count) {
  FreeRays rays;
  for (std::uint64_t i = 0; i < count; ++i) {
    const double polar = 80 * kPi / 180 * hashedUnit(5 * i), azimuth = 2 * kPi * hashedUnit(5 * i + 1);
    const double down = i % 3 == 0 ? 1 : -1;
    const Vec3 direction(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
                         down * std::cos(polar));
    rays.push(
        Vec3(hashedUnit(5 * i + 2), 0.5 * hashedUnit(5 * i + 3), depth * (2 * hashedUnit(5 * i + 4) - 1)),
        direction);
  }
  return rays;
}

struct Case {
  double depth;
  bool holes;
};

class PeriodicRays : public testing::TestWithParam<Case> {};

TEST_P(PeriodicRays, MeetWhatTheyMeetInAWideSurface) {
  const auto [depth, holes] = GetParam();
  const TriangleMesh mesh = waves(depth, holes);
  const PeriodicRayScene scene(mesh, {1, 0.5});
  const int reach = 3 + static_cast<int>(std::ceil(2 * depth * std::tan(80 * kPi / 180)));
  const RayScene wide(laidOut(mesh, reach, 2 * reach));
  const FreeRays rays = someRays(depth, 3000);
  HitBundle hits(rays.size());
  scene.nearestHits(rays, hits);
  std::vector<std::uint8_t> blocked(rays.size());
  scene.occluded(rays, blocked);
  int met = 0, different = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Hit right = wide.nearestHit(Vec3(rays.x[i], rays.y[i], rays.z[i]),
                                      Vec3(rays.direction_x[i], rays.direction_y[i], rays.direction_z[i]));
    EXPECT_EQ(hits.blocked[i], blocked[i]) << i;
    met += right.valid ? 1 : 0;
    const bool same =
        right.valid == (hits.blocked[i] != 0) &&
        (!right.valid || (std::abs(right.distance - hits.distance[i]) < 1e-4 * (1 + right.distance) &&
                          right.triangle % mesh.triangleCount() == hits.triangle[i] &&
                          right.back_face == (hits.back_face[i] != 0)));
    different += same ? 0 : 1;
  }
  EXPECT_GT(met, 1000);
  EXPECT_LE(different, 3);  // along an edge of two triangles
}

INSTANTIATE_TEST_SUITE_P(All, PeriodicRays,
                         testing::Values(Case{0.1, false}, Case{0.1, true}, Case{0.6, true},
                                         Case{1.4, true}));

TEST(PeriodicRayScene, HasNoHitsWhereThereIsNoSurface) {
  const PeriodicRayScene scene(TriangleMesh{}, {1, 1});
  FreeRays rays;
  rays.push(Vec3(0.5, 0.5, 1), Vec3(0, 0, -1));
  rays.push(Vec3(0.5, 0.5, 0), Vec3(1, 0, 0));
  HitBundle hits(rays.size());
  scene.nearestHits(rays, hits);
  EXPECT_EQ(hits.blocked, (std::vector<std::uint8_t>{0, 0}));
}

// In the plane of a flat surface, and between waves for ever.
TEST(PeriodicRayScene, HorizontalRaysEnd) {
  const PeriodicRayScene flat(waves(0, false), {1, 0.5}), deep(waves(1, false), {1, 0.5});
  FreeRays rays;
  rays.push(Vec3(0.5, 0.25, 0), Vec3(1, 0, 0));
  rays.push(Vec3(0.5, 0.25, 0.2), Vec3(0, 1, 0));
  rays.push(Vec3(0.5, 0.125, 0.49), Vec3(0, 1, 1e-7));
  HitBundle hits(rays.size());
  flat.nearestHits(rays, hits);
  deep.nearestHits(rays, hits);
  EXPECT_EQ(hits.blocked.size(), 3U);
}

}  // namespace
}  // namespace bakelight::transport
