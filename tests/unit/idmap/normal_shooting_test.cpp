// Normal shooting finds what an exhaustive search finds, and stays on its sheet.
#include "tools/idmap/normal_shooting.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/shapes.h"
#include "tools/idmap/nearest_points.h"
#include "transport/random.h"
#include "transport/vector_types.h"

namespace bakelight::idmap {
namespace {

using formats::TriangleMesh;
using transport::float3;
using transport::Vec3;
using transport::vec3;

double random(std::uint64_t i) {
  return static_cast<double>(transport::scrambled(i) >> 11) * 0x1p-53;
}

// (n + 1)² vertices over a unit square at height y, facing up or down.
TriangleMesh sheet(int n, float y, float up) {
  TriangleMesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double side = n;
      mesh.positions.push_back({static_cast<float>(i / side), y, static_cast<float>(j / side)});
      mesh.normals.push_back({0, up, 0});
    }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(j * (n + 1) + i); };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
      mesh.triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
    }
  return mesh;
}

// The paper's rule.
std::uint32_t exhaustive(const TriangleMesh& mesh, const Shot& shot, std::size_t k) {
  std::vector<std::pair<double, std::uint32_t>> all;
  for (std::uint32_t v = 0; v < mesh.vertexCount(); ++v)
    all.emplace_back(squaredDistance(mesh.positions[v], shot.position), v);
  std::sort(all.begin(), all.end());
  std::uint32_t best = NormalShooting::kNone;
  double least = 0;
  for (std::size_t i = 0; i < std::min(k, all.size()); ++i) {
    const Vec3 normal = vec3(shot.normal), way = vec3(mesh.positions[all[i].second]) - vec3(shot.position);
    if (normal.dot(vec3(mesh.normals[all[i].second])) <= 0) continue;
    const double line = (way - way.dot(normal) * normal).squaredNorm();
    if (best == NormalShooting::kNone || line < least) best = all[i].second, least = line;
  }
  return best;
}

// A little inside a ball of radius 1, outwards but not quite.
std::vector<Shot> shotsOfBall(std::size_t count) {
  std::vector<Shot> shots;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 p = Vec3(random(5 * i) - 0.5, random(5 * i + 1) - 0.5, random(5 * i + 2) - 0.5).normalized();
    const Vec3 n = (p + 0.3 * Vec3(random(5 * i + 3), random(5 * i + 4), 0)).normalized();
    shots.push_back({float3(0.99 * p), float3(n)});
  }
  return shots;
}

TEST(NormalShooting, FindsWhatAnExhaustiveSearchFinds) {
  const TriangleMesh ball = tests::icosphere(4);
  const std::vector<Shot> shots = shotsOfBall(2000);
  for (const std::size_t k : {1, 5, 20, 100}) {
    const NormalShooting shooting({ball, {}}, k);
    std::vector<std::uint32_t> found(shots.size());
    const ShotFigures figures = shooting.shoot(shots, found);
    EXPECT_EQ(figures.shots, shots.size());
    std::size_t compared = 0;
    for (std::size_t i = 0; i < shots.size(); ++i) {
      const std::uint32_t right = exhaustive(ball, shots[i], k);
      if (right == NormalShooting::kNone) continue;
      ++compared;
      EXPECT_EQ(found[i], right) << "k " << k << ", shot " << i;
    }
    EXPECT_GT(compared, 1900u);
  }
}

TEST(NormalShooting, ShotsSideBySideFindWhatEachFindsAlone) {
  const TriangleMesh ball = tests::icosphere(4);
  std::vector<Shot> shots;
  for (int i = 0; i < 400; ++i) {
    const Vec3 p = Vec3(1, 0.002 * i, 0.001 * (i % 7)).normalized();
    shots.push_back({float3(p), float3(p)});
  }
  const NormalShooting shooting({ball, {}}, 20);
  std::vector<std::uint32_t> together(shots.size()), alone(shots.size());
  shooting.shoot(shots, together);
  for (std::size_t i = 0; i < shots.size(); ++i) {
    shooting.shoot(std::span(shots).subspan(i, 1), std::span(alone).subspan(i, 1));
    EXPECT_EQ(together[i], exhaustive(ball, shots[i], 20)) << i;
  }
  EXPECT_EQ(together, alone);
}

TEST(NormalShooting, MoreNeighborsThanVerticesMeansAll) {
  const TriangleMesh tetrahedron = tests::icosphere(0);
  const NormalShooting shooting({tetrahedron, {}}, 1000);
  const std::vector<Shot> shots = {{tetrahedron.positions[7], tetrahedron.normals[7]}};
  std::vector<std::uint32_t> found(1);
  EXPECT_EQ(shooting.shoot(shots, found).widened, 0u);
  EXPECT_EQ(found[0], 7u);
}

// A thin plate: of the nearest vertices half are of the other side.
TEST(NormalShooting, StaysOnItsSideOfAThinPlate) {
  constexpr int kCells = 40;
  TriangleMesh plate = sheet(kCells, 0.001F, 1);
  const std::size_t upper = plate.vertexCount();
  TriangleMesh below = sheet(kCells, -0.001F, -1);
  for (formats::Triangle& t : below.triangles) std::swap(t[1], t[2]);
  tests::append(plate, below);
  const NormalShooting shooting({plate, {}}, 20);
  std::vector<Shot> shots;
  for (std::uint64_t i = 0; i < 1000; ++i)
    shots.push_back({{static_cast<float>(random(2 * i)), 0.001F, static_cast<float>(random(2 * i + 1))},
                     {0, i % 2 == 0 ? 1.0F : -1.0F, 0}});
  std::vector<std::uint32_t> found(shots.size());
  shooting.shoot(shots, found);
  for (std::size_t i = 0; i < shots.size(); ++i) EXPECT_EQ(found[i] < upper, i % 2 == 0) << i;
}

// Two sheets that face the same way, shifted, closer than their vertices are to each other: the vertex nearest
// to the line is often one of the other sheet.
TEST(NormalShooting, StaysOnItsSheetOfTwoThatFaceTheSameWay) {
  constexpr int kCells = 40;
  TriangleMesh sheets = sheet(kCells, 0, 1);
  const std::size_t lower = sheets.vertexCount();
  TriangleMesh above = sheet(kCells, 0.018F, 1);
  for (formats::Float3& p : above.positions) p[0] += 0.4F / kCells, p[2] += 0.4F / kCells;
  tests::append(sheets, above);
  const NormalShooting shooting({sheets, {}}, 20);
  std::vector<Shot> shots;
  for (std::uint64_t i = 0; i < 1000; ++i)
    shots.push_back({{static_cast<float>(0.1 + 0.8 * random(2 * i)), i % 2 == 0 ? 0.0F : 0.018F,
                      static_cast<float>(0.1 + 0.8 * random(2 * i + 1))},
                     {0, 1, 0}});
  std::vector<std::uint32_t> found(shots.size());
  const ShotFigures figures = shooting.shoot(shots, found);
  std::size_t rule_alone = 0;
  for (std::size_t i = 0; i < shots.size(); ++i) {
    EXPECT_EQ(found[i] < lower, i % 2 == 0) << i;
    rule_alone += (exhaustive(sheets, shots[i], 20) < lower) != (i % 2 == 0) ? 1 : 0;
  }
  EXPECT_GT(rule_alone, 200u) << "the sheets must be such that the line alone would not do";
  EXPECT_EQ(figures.other_sheets, rule_alone);
}

TEST(NormalShooting, LooksFartherWhereNothingNearFacesItsWay) {
  TriangleMesh plate = sheet(20, 0, -1);
  TriangleMesh far = sheet(2, -3, 1);
  const auto first = static_cast<std::uint32_t>(plate.vertexCount());
  tests::append(plate, far);
  const NormalShooting shooting({plate, {}}, 20);
  const std::vector<Shot> shots = {{{0.5F, 0, 0.5F}, {0, 1, 0}}};
  std::vector<std::uint32_t> found(1);
  EXPECT_EQ(shooting.shoot(shots, found).widened, 1u);
  EXPECT_EQ(found[0], first + 4);
}

// A search that goes farther stands between others of one group.
TEST(NormalShooting, LookingFartherLeavesTheNextShotsAlone) {
  TriangleMesh ball = tests::icosphere(4);
  std::vector<std::uint32_t> materials(ball.vertexCount(), 0);
  for (std::size_t v = 0; v < materials.size(); ++v) materials[v] = ball.positions[v][0] < -0.9F ? 1 : 0;
  const NormalShooting shooting({ball, materials}, 20);
  std::vector<Shot> shots;
  for (int i = 0; i < 64; ++i) {
    const Vec3 p = Vec3(1, 0.0005 * i, 0).normalized();
    shots.push_back({float3(p), float3(p), i % 4 == 1 ? 1U : 0U});
  }
  // Of the other material's vertices, none faces that way.
  for (Shot& shot : shots)
    if (shot.material == 1U) shot.normal = {-1, 0, 0};
  std::vector<std::uint32_t> found(shots.size());
  const ShotFigures figures = shooting.shoot(shots, found);
  EXPECT_EQ(figures.widened, 16u);
  for (std::size_t i = 0; i < shots.size(); ++i) {
    ASSERT_LT(found[i], ball.vertexCount()) << i;
    EXPECT_EQ(materials[found[i]], *shots[i].material) << i;
    if (shots[i].material == 0U) {
      EXPECT_EQ(found[i], exhaustive(ball, shots[i], 20)) << i;
    }
  }
}

TEST(NormalShooting, FindsNothingWhereNothingFacesItsWay) {
  const TriangleMesh plate = sheet(10, 0, -1);
  const NormalShooting shooting({plate, {}}, 20);
  const std::vector<Shot> shots = {{{0.5F, 0, 0.5F}, {0, 1, 0}}};
  std::vector<std::uint32_t> found(1);
  shooting.shoot(shots, found);
  EXPECT_EQ(found[0], NormalShooting::kNone);
}

TEST(NormalShooting, OfCoincidentVerticesTakesTheFirst) {
  TriangleMesh stacked;
  for (int copy = 0; copy < 30; ++copy) tests::append(stacked, sheet(3, 0, 1));
  const NormalShooting shooting({stacked, {}}, 20);
  const std::vector<Shot> shots = {{{0.34F, 0.1F, 0.3F}, {0, 1, 0}}};
  std::vector<std::uint32_t> found(1);
  shooting.shoot(shots, found);
  EXPECT_EQ(found[0], 5u);
}

TEST(NormalShooting, TakesVerticesOfItsMaterialOnly) {
  const TriangleMesh square = sheet(10, 0, 1);
  std::vector<std::uint32_t> materials;
  for (const formats::Float3& p : square.positions) materials.push_back(p[0] > 0.5F ? 1 : 0);
  const NormalShooting shooting({square, materials}, 20);
  std::vector<Shot> shots;
  for (int i = 0; i < 100; ++i)
    shots.push_back({{0.45F + 0.001F * static_cast<float>(i), 0, 0.52F}, {0, 1, 0}, 1});
  std::vector<std::uint32_t> found(shots.size());
  shooting.shoot(shots, found);
  for (const std::uint32_t v : found) EXPECT_EQ(materials[v], 1u);
}

// Far from the origin, where neighbors are a few float spacings apart.
TEST(NormalShooting, IsRightFarFromTheOrigin) {
  TriangleMesh ball = tests::icosphere(3, 10, Vec3(1e5, 0, 0));
  std::vector<Shot> shots;
  for (std::size_t v = 0; v < ball.vertexCount(); v += 3)
    shots.push_back({ball.positions[v], ball.normals[v]});
  const NormalShooting shooting({ball, {}}, 20);
  std::vector<std::uint32_t> found(shots.size());
  shooting.shoot(shots, found);
  for (std::size_t i = 0; i < shots.size(); ++i) EXPECT_EQ(found[i], 3 * i);
}

}  // namespace
}  // namespace bakelight::idmap
