#include "tools/transfer/pixel_transfer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "tests/support/shapes.h"
#include "tests/unit/transfer/bake.h"
#include "transport/cube_map.h"
#include "transport/hemisphere_grid.h"
#include "transport/sh.h"

namespace bakelight::transfer {
namespace {

using namespace bakelight::tests;
using formats::PixelCodes;
using formats::PixelRows;

constexpr double kPi = std::numbers::pi;

std::vector<double> solidAngles(int side) {
  std::vector<double> angles;
  for (int face = 0; face < transport::kCubeFaces; ++face)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) angles.push_back(transport::cubeTexelSolidAngle(x, y, side));
  return angles;
}

Vec3 middleOf(std::size_t texel, int side) {
  const auto x = static_cast<int>(texel) % side, y = static_cast<int>(texel) / side % side,
             face = static_cast<int>(texel) / (side * side);
  return transport::directionOfCubeFace(face, (x + 0.5) / side, (y + 0.5) / side);
}

struct Entry {
  std::size_t cell, column;
  double share;
};
std::vector<Entry> entriesOf(const PixelCodes& codes, std::size_t vertex) {
  const auto cells = static_cast<std::size_t>(codes.local_side) * codes.local_side;
  std::vector<Entry> entries;
  for (std::size_t cell = 0; cell < cells; ++cell)
    for (std::uint64_t i = codes.row_offsets[vertex * cells + cell];
         i < codes.row_offsets[vertex * cells + cell + 1]; ++i)
      entries.push_back({cell, codes.columns[i],
                         codes.codes[i] / static_cast<double>(codes.subsamples * codes.subsamples)});
  return entries;
}

double seenSolidAngle(const PixelCodes& codes, std::size_t vertex) {
  const std::vector<double> angles = solidAngles(codes.cube_side);
  double sum = 0;
  for (const Entry& entry : entriesOf(codes, vertex)) sum += entry.share * angles[entry.column];
  return sum;
}

void expectValid(const PixelRows& rows, std::size_t vertices) {
  const PixelCodes codes = rows.view();
  ASSERT_EQ(codes.rowCount(), vertices * static_cast<std::size_t>(codes.local_side * codes.local_side));
  ASSERT_EQ(codes.row_offsets.front(), 0U);
  ASSERT_EQ(codes.row_offsets.back(), codes.codes.size());
  ASSERT_EQ(codes.columns.size(), codes.codes.size());
  for (std::size_t row = 0; row < codes.rowCount(); ++row) {
    ASSERT_LE(codes.row_offsets[row], codes.row_offsets[row + 1]);
    for (std::uint64_t i = codes.row_offsets[row]; i < codes.row_offsets[row + 1]; ++i) {
      ASSERT_LT(codes.columns[i], codes.columnCount());
      if (i > codes.row_offsets[row]) {
        ASSERT_LT(codes.columns[i - 1], codes.columns[i]);
      }
      ASSERT_GE(codes.codes[i], 1);
      ASSERT_LE(codes.codes[i], codes.subsamples * codes.subsamples);
    }
  }
}

// A square in z = 0 facing +z, and a wall through the origin's x = 0 that hides all of x < 0.
TriangleMesh openSquare(double size) {
  TriangleMesh mesh;
  for (const auto& [x, y] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}}) {
    mesh.positions.push_back(float3(size * Vec3(x, y, 0)));
    mesh.normals.push_back({0, 0, 1});
  }
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}
TriangleMesh pointBesideWall(double distance) {
  TriangleMesh mesh;
  mesh.positions = {{static_cast<float>(distance), 0, 0}, {0, -1e5F, -1e5F}, {0, 1e5F, -1e5F}, {0, 0, 1e5F}};
  mesh.normals = {{0, 0, 1}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}};
  mesh.triangles = {{1, 2, 3}};
  return mesh;
}

TEST(PixelTransfer, OfAConvexBodyIsTheHemisphere) {
  const TriangleMesh ball = icosphere(2);
  for (const int local_side : {1, 8, 12, 32}) {
    const PixelBlock block = bakePixelTransfer(ball, {.local_side = local_side});
    expectValid(block.rows, ball.vertexCount());
    const PixelCodes codes = block.rows.view();
    for (std::size_t v = 0; v < ball.vertexCount(); v += 17) {
      const std::vector<Entry> entries = entriesOf(codes, v);
      std::set<std::size_t> columns;
      for (const Entry& entry : entries) {
        EXPECT_TRUE(columns.insert(entry.column).second) << "texel " << entry.column << " is in two cells";
        EXPECT_GT(middleOf(entry.column, 32).dot(vec3(ball.normals[v])), -0.05);
      }
      // Rows at the horizon are cut off by 2 × 2 points a texel; the triangles around lie below the tangent plane.
      EXPECT_NEAR(seenSolidAngle(codes, v), 2 * kPi, 0.004 * 2 * kPi);
    }
    EXPECT_EQ(block.figures.blocked_rays, 0U);
  }
}

TEST(PixelTransfer, PutsEachTexelInTheCellOfItsMiddle) {
  const TriangleMesh ball = icosphere(1);
  const PixelBaker baker(ball, {.cube_side = 16, .local_side = 6});
  const PixelRows rows = baker.bake({0, ball.vertexCount()}).rows;
  for (std::size_t v = 0; v < ball.vertexCount(); v += 5) {
    const Eigen::Matrix3d local = localFromObject(ball.normals[v], baker.tangents()[v]);
    for (const Entry& entry : entriesOf(rows.view(), v)) {
      const transport::SquarePoint place =
          transport::squareFromHemisphere(local * middleOf(entry.column, 16));
      const double column = static_cast<double>(entry.cell % 6), row = static_cast<double>(entry.cell / 6);
      EXPECT_NEAR(place.a * 6, column + 0.5, 0.5 + 1e-9);
      EXPECT_NEAR(place.b * 6, row + 0.5, 0.5 + 1e-9);
    }
  }
}

TEST(PixelTransfer, BesideAWallIsHalf) {
  const TriangleMesh mesh = pointBesideWall(1);
  const PixelBlock block = bakePixelTransfer(mesh, {});
  expectValid(block.rows, mesh.vertexCount());
  // An infinite wall hides the quarter sphere of x < 0.
  EXPECT_NEAR(seenSolidAngle(block.rows.view(), 0), kPi, 0.005 * kPi);
  for (const Entry& entry : entriesOf(block.rows.view(), 0))
    EXPECT_GT(middleOf(entry.column, 32).x(), -0.04) << "seen through the wall";
  const PixelBlock open = bakePixelTransfer(mesh, {.shadows = false});
  EXPECT_NEAR(seenSolidAngle(open.rows.view(), 0), 2 * kPi, 0.005 * kPi);
}

TEST(PixelTransfer, InAClosedCavityIsNothing) {
  const TriangleMesh cavity = insideOut(icosphere(2));
  const PixelBlock block = bakePixelTransfer(cavity, {.cube_side = 8});
  expectValid(block.rows, cavity.vertexCount());
  EXPECT_TRUE(block.rows.codes.empty());
  EXPECT_EQ(block.figures.fully_blocked_vertices, cavity.vertexCount());
  EXPECT_EQ(block.figures.buried_vertices, 0U);
}

TEST(PixelTransfer, OfASingleVertexIsItsHemisphere) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}};
  mesh.normals = {{0, 1, 0}};
  const PixelBlock block = bakePixelTransfer(mesh, {.cube_side = 8, .local_side = 4});
  expectValid(block.rows, 1);
  EXPECT_NEAR(seenSolidAngle(block.rows.view(), 0), 2 * kPi, 1e-9);  // the horizon runs between texels
}

// A vertex inside a ball takes over what a neighbor sees that lies outside.
TEST(PixelTransfer, BuriedVerticesSeeWhatTheirNeighborsDo) {
  TriangleMesh mesh = icosphere(3);
  const auto base = static_cast<std::uint32_t>(mesh.vertexCount());
  // A spike out of the ball's top, its foot inside.
  for (const Vec3& p : {Vec3(0, 0.5, 0.03), Vec3(0.05, 1.6, 0.03), Vec3(-0.05, 1.6, 0.03)}) {
    mesh.positions.push_back(float3(p));
    mesh.normals.push_back({0, 0, 1});
  }
  mesh.triangles.push_back({base, base + 1, base + 2});
  const PixelBlock block = bakePixelTransfer(mesh, {});
  expectValid(block.rows, mesh.vertexCount());
  EXPECT_EQ(block.figures.buried_vertices, 1U);
  EXPECT_EQ(block.figures.filled_vertices, 1U);
  EXPECT_EQ(block.figures.fully_blocked_vertices, 0U);
  const double neighbor = seenSolidAngle(block.rows.view(), base + 1);
  EXPECT_GT(neighbor, kPi);
  EXPECT_EQ(seenSolidAngle(block.rows.view(), base), neighbor);
}

// Under a smooth light, what the cells gather by their cosines is what the transfer vector of spherical harmonics says.
TEST(PixelTransfer, AgreesWithTransferVectors) {
  TriangleMesh mesh = icosphere(2);
  append(mesh, icosphere(2, 0.6, Vec3(1.6, 0.8, 0.2)));
  append(mesh, icosphere(2, 0.5, Vec3(-0.4, 1.7, 0)));
  const int order = 4;
  const Transfer vectors = bake(mesh, {.order = order, .directions = 16384});
  const PixelBlock block = bakePixelTransfer(mesh, {.local_side = 32});
  const std::vector<double> angles = solidAngles(32);
  std::vector<double> light(angles.size());
  std::vector<double> coefficients(transport::coefficientCount(order));
  std::vector<double> basis(coefficients.size());
  for (std::size_t i = 0; i < coefficients.size(); ++i)
    coefficients[i] = i == 0 ? 4 : std::cos(3.7 * static_cast<double>(i));
  for (std::size_t texel = 0; texel < light.size(); ++texel) {
    transport::evaluateSh(order, middleOf(texel, 32), basis);
    for (std::size_t i = 0; i < basis.size(); ++i) light[texel] += coefficients[i] * basis[i];
  }
  double squared = 0, difference = 0;
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
    double expected = 0, gathered = 0;
    for (std::size_t i = 0; i < coefficients.size(); ++i)
      expected += coefficients[i] * vectors.vectors[v * coefficients.size() + i];
    for (const Entry& entry : entriesOf(block.rows.view(), v)) {
      const auto cell = static_cast<int>(entry.cell);
      gathered += entry.share * light[entry.column] * angles[entry.column] *
                  transport::hemisphereCell(32, cell % 32, cell / 32).z() / kPi;
    }
    EXPECT_NEAR(gathered, expected, 0.02) << v;  // of about 1
    squared += expected * expected;
    difference += (gathered - expected) * (gathered - expected);
  }
  EXPECT_LT(std::sqrt(difference / squared), 0.006);
}

// The edge of a shadow that a single texel of sun casts is where the rays say.
TEST(PixelTransfer, ASunsShadowIsWhatRaysSay) {
  TriangleMesh mesh = openSquare(1);
  mesh.positions.clear(), mesh.normals.clear(), mesh.triangles.clear();
  constexpr int kSide = 24;
  for (int y = 0; y <= kSide; ++y)
    for (int x = 0; x <= kSide; ++x) {
      mesh.positions.push_back({static_cast<float>(x) / 12 - 1, static_cast<float>(y) / 12 - 1, 0});
      mesh.normals.push_back({0, 0, 1});
    }
  const std::size_t ground = mesh.vertexCount();
  for (std::uint32_t y = 0; y < kSide; ++y)
    for (std::uint32_t x = 0; x < kSide; ++x) {
      const std::uint32_t a = y * (kSide + 1) + x;
      mesh.triangles.push_back({a, a + 1, a + kSide + 2});
      mesh.triangles.push_back({a, a + kSide + 2, a + kSide + 1});
    }
  append(mesh, icosphere(3, 0.3, Vec3(0, 0, 0.8)));
  const PixelBlock block = bakePixelTransfer(mesh, {.cube_side = 16, .subsamples = 4});
  const auto [face, s, t] = transport::cubeFaceOfDirection(Vec3(0.4, 0.2, 0.9));
  const int x = static_cast<int>(s * 16), y = static_cast<int>(t * 16);
  const auto sun = static_cast<std::size_t>((face * 16 + y) * 16 + x);
  const transport::RayScene scene(mesh);
  int partial = 0, dark = 0;
  for (std::size_t v = 0; v < ground; ++v) {
    double share = 0;
    for (const Entry& entry : entriesOf(block.rows.view(), v))
      if (entry.column == sun) share = entry.share;
    int passing = 0;
    for (int j = 0; j < 20; ++j)
      for (int i = 0; i < 20; ++i)
        passing += scene.occluded(Vec3(vec3(mesh.positions[v])) + Vec3(0, 0, 1e-4),
                                  transport::directionOfCubeFace(face, (x + (i + 0.5) / 20) / 16,
                                                                 (y + (j + 0.5) / 20) / 16))
                       ? 0
                       : 1;
    EXPECT_NEAR(share, passing / 400.0, 0.16) << v;
    partial += share > 0 && share < 1 ? 1 : 0;
    dark += share == 0 ? 1 : 0;
  }
  EXPECT_GT(dark, 20);
  EXPECT_GT(partial, 5);
}

TEST(PixelTransfer, IsTheSameInRangesAndOnAnyNumberOfThreads) {
  TriangleMesh mesh = icosphere(3);
  append(mesh, icosphere(2, 0.5, Vec3(1, 0.7, 0)));
  const PixelBaker baker(mesh, {.cube_side = 16});
  const std::size_t count = mesh.vertexCount();
  const PixelBlock whole = baker.bake({0, count});
  EXPECT_GT(whole.figures.buried_vertices, 0U);
  PixelBlock parts = baker.bake({0, 37});
  for (const PointRange& range : {PointRange{37, 37}, PointRange{37, 400}, PointRange{400, count}}) {
    const PixelBlock next = baker.bake(range);
    parts.rows.append(next.rows);
    parts.figures.add(next.figures);
  }
  const auto expectSame = [&](const PixelBlock& other) {
    EXPECT_EQ(other.rows.row_offsets, whole.rows.row_offsets);
    EXPECT_EQ(other.rows.columns, whole.rows.columns);
    EXPECT_EQ(other.rows.codes, whole.rows.codes);
    EXPECT_EQ(other.figures.rays, whole.figures.rays);
    EXPECT_EQ(other.figures.filled_vertices, whole.figures.filled_vertices);
  };
  expectSame(parts);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  expectSame(bakePixelTransfer(mesh, {.cube_side = 16}));
}

TEST(PixelTransfer, RefusesSizesThatCodesCannotHold) {
  const TriangleMesh ball = icosphere(0);
  EXPECT_THROW(bakePixelTransfer(ball, {.cube_side = 105}), std::invalid_argument);
  EXPECT_THROW(bakePixelTransfer(ball, {.subsamples = 16}), std::invalid_argument);
  EXPECT_THROW(bakePixelTransfer(ball, {.local_side = 0}), std::invalid_argument);
  TriangleMesh point;
  point.positions = {{0, 0, 0}};
  point.normals = {{0.6F, 0, 0.8F}};
  const PixelBlock finest = bakePixelTransfer(point, {.cube_side = 104, .local_side = 32, .subsamples = 15});
  expectValid(finest.rows, 1);
  EXPECT_NEAR(seenSolidAngle(finest.rows.view(), 0), 2 * kPi, 1e-3);
}

}  // namespace
}  // namespace bakelight::transfer
