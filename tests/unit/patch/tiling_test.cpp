#include "patch/tiling.h"
#include "transport/texture_frames.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "formats/error.h"
#include "tests/support/patches.h"
#include "tests/support/shapes.h"

namespace bakelight::patch {
namespace {

using formats::Triangle;
using formats::TriangleMesh;
using transport::Vec3;
using transport::vec3;

constexpr double kPi = std::numbers::pi;

// A grid of quads over [0, 1]², bent by `place`, which gives position and normal.
template <class PlaceAt>
TriangleMesh gridSurface(int columns, int rows, const PlaceAt& place, bool mirrored = false) {
  TriangleMesh mesh;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      const double u = static_cast<double>(i) / columns, v = static_cast<double>(j) / rows;
      const auto [position, normal] = place(u, v);
      mesh.positions.push_back(transport::float3(position));
      mesh.normals.push_back(transport::float3(normal));
      mesh.texcoords.push_back({static_cast<float>(mirrored ? 1 - u : u), static_cast<float>(v)});
    }
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const auto a = static_cast<std::uint32_t>(j * (columns + 1) + i),
                 c = a + static_cast<std::uint32_t>(columns) + 1;
      mesh.triangles.insert(mesh.triangles.end(), {{a, a + 1, c + 1}, {a, c + 1, c}});
    }
  return mesh;
}

struct Placed {
  Vec3 position, normal;
};

// `size` wide, facing +y; u along +x, v along −z.
TriangleMesh plane(double size, bool mirrored = false) {
  return gridSurface(
      3, 3,
      [size](double u, double v) {
        return Placed{Vec3(size * u, 0, -size * v), Vec3(0, 1, 0)};
      },
      mirrored);
}

// Around z, as long as its girth; u is around.
constexpr double kRadius = 2;
TriangleMesh cylinder(int around) {
  return gridSurface(around, around, [](double u, double v) {
    const Vec3 normal(std::cos(2 * kPi * u), std::sin(2 * kPi * u), 0);
    return Placed{kRadius * normal + Vec3(0, 0, 2 * kPi * kRadius * v), normal};
  });
}

PatchGeometry bumps(int side = 12) {
  return tests::heightPatch(side, 0.4, tests::waves);
}

TriangleMesh laid(const PatchGeometry& patch, const TriangleMesh& surface, double width) {
  const TiledSurface result =
      tiled(patch, surface, {transport::surfaceUnitOf(surface) / width, width}, "surface");
  EXPECT_EQ(result.bare_triangles, 0);
  return result.mesh;
}

double radiusOf(const formats::Float3& p) {
  return std::hypot(p[0], p[1]);
}

Vec3 facetOf(const TriangleMesh& mesh, const Triangle& t) {
  const Vec3 a = vec3(mesh.positions[t[0]]);
  return (vec3(mesh.positions[t[1]]) - a).cross(vec3(mesh.positions[t[2]]) - a);
}

// Sides of triangles that no other triangle has, of vertices welded by cells of 10⁻⁴; three times, as two that are one
// may be on both sides of a cell's wall.
std::size_t openEdges(const TriangleMesh& mesh, const std::function<bool(const Vec3&)>& counts) {
  using Key = std::array<long, 3>;
  std::vector<int> times_open(3 * mesh.triangleCount(), 0);
  const auto end = [&](std::size_t side, std::size_t k) {
    return mesh.positions[mesh.triangles[side / 3][(side + k) % 3]];
  };
  for (const double offset : {0.0, 1.0 / 3, 2.0 / 3}) {
    const auto key = [&](const formats::Float3& p) {
      return Key{std::lround(1e4 * p[0] + offset), std::lround(1e4 * p[1] + offset),
                 std::lround(1e4 * p[2] + offset)};
    };
    std::map<std::array<Key, 2>, std::vector<std::size_t>> edges;
    for (std::size_t side = 0; side < times_open.size(); ++side) {
      std::array<Key, 2> ends = {key(end(side, 0)), key(end(side, 1))};
      if (ends[0] == ends[1]) continue;
      std::sort(ends.begin(), ends.end());
      edges[ends].push_back(side);
    }
    for (const auto& [ends, sides] : edges)
      if (sides.size() == 1) ++times_open[sides.front()];
  }
  std::size_t open = 0;
  for (std::size_t side = 0; side < times_open.size(); ++side)
    open += times_open[side] == 3 && counts((vec3(end(side, 0)) + vec3(end(side, 1))) / 2) ? 1 : 0;
  return open;
}

TEST(TiledPatch, FlatOverAPlaneIsThePlane) {
  const TriangleMesh mesh = laid(tests::flatPatch({0.5F, 0.25F, 1}), plane(3), 0.5);
  EXPECT_NEAR(tests::surfaceArea(mesh), 9, 1e-5);
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
    EXPECT_NEAR(mesh.positions[v][1], 0, 1e-6);
    EXPECT_NEAR(mesh.normals[v][1], 1, 1e-6);
    EXPECT_EQ(mesh.colors[v], (formats::Float3{0.5F, 0.25F, 1}));
    // Six patches across: the place in the patch is the place on the plane, in widths.
    EXPECT_NEAR(mesh.texcoords[v][0], mesh.positions[v][0] / 0.5, 1e-5);
    EXPECT_NEAR(mesh.texcoords[v][1], -mesh.positions[v][2] / 0.5, 1e-5);
  }
}

TEST(TiledPatch, FlatOverACylinderLiesOnIt) {
  constexpr int kAround = 48;
  const TriangleMesh surface = cylinder(kAround), mesh = laid(tests::flatPatch({1, 1, 1}), surface, 1.2);
  EXPECT_NEAR(tests::surfaceArea(mesh), tests::surfaceArea(surface), 1e-4);
  const double nearest = kRadius * std::cos(kPi / kAround);  // middles of facets
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
    EXPECT_GT(radiusOf(mesh.positions[v]), nearest - 1e-5);
    EXPECT_LT(radiusOf(mesh.positions[v]), kRadius + 1e-5);
    const Vec3 out = Vec3(mesh.positions[v][0], mesh.positions[v][1], 0).normalized();
    EXPECT_GT(vec3(mesh.normals[v]).dot(out), 1 - 1e-4);
  }
}

// Highest and lowest, at ±0.5 · depth · width beside the surface, and where they are.
TEST(TiledPatch, HeightsStandAlongTheNormals) {
  const PatchGeometry patch = bumps();
  double highest = 0;
  Vec3 top = Vec3::Zero();
  for (const formats::Float3& p : patch.mesh.positions)
    if (p[2] > highest) highest = p[2], top = vec3(p);
  ASSERT_GT(highest, 0.1);

  const TriangleMesh flat = laid(patch, plane(3), 1);
  double most = -1;
  Vec3 at = Vec3::Zero();
  for (const formats::Float3& p : flat.positions)
    if (p[1] > most) most = p[1], at = vec3(p);
  EXPECT_NEAR(most, highest, 1e-5);
  // Once in each of the widths: u goes along +x, v along −z.
  EXPECT_NEAR(std::remainder(at.x() - top.x(), 1), 0, 1e-5);
  EXPECT_NEAR(std::remainder(-at.z() - top.y(), 1), 0, 1e-5);

  const double width = 2 * kPi * kRadius / 6;
  double farthest = 0, nearest = 10;
  for (const formats::Float3& p : laid(patch, cylinder(96), width).positions)
    farthest = std::max(farthest, radiusOf(p)), nearest = std::min(nearest, radiusOf(p));
  EXPECT_NEAR(farthest, kRadius + highest * width, 2e-3);
  EXPECT_NEAR(nearest, kRadius - highest * width, 2e-3);
}

// The area of what is displaced along a plane is the patch's, as often as it is there.
TEST(TiledPatch, KeepsThePatchsArea) {
  const PatchGeometry patch = bumps();
  const TriangleMesh mesh = laid(patch, plane(3), 0.75);
  EXPECT_NEAR(tests::surfaceArea(mesh), 16 * 0.75 * 0.75 * tests::surfaceArea(patch.mesh), 1e-3);
}

TEST(TiledPatch, ClosesSeamsWhereThePatchContinues) {
  const double length = 2 * kPi * kRadius;
  const auto inside = [&](const Vec3& p) { return p.z() > 1e-3 && p.z() < length - 1e-3; };
  // Also at the chart's border, where u goes from 1 to 0. Facets and patches do not end at the same places.
  const auto open = [&](double repeats) {
    return openEdges(tiled(bumps(), cylinder(32), {repeats, length / repeats}, "").mesh, inside);
  };
  EXPECT_EQ(open(5), 0);
  EXPECT_GT(open(5.5), 100);
}

TEST(TiledPatch, TellsOfEdgesThatDoNotContinue) {
  const double length = 2 * kPi * kRadius;
  const TriangleMesh surface = cylinder(8);
  EXPECT_EQ(tiled(bumps(), surface, {5, length / 5}, "").broken_edges, 0);
  EXPECT_EQ(tiled(bumps(), surface, {5.5, length / 5.5}, "").broken_edges, 8);
}

// Least cosine between a triangle and its vertices' normals.
double worstNormal(const TriangleMesh& mesh) {
  double worst = 1;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 facet = facetOf(mesh, t);
    if (facet.norm() < 1e-5) continue;  // splinters, whose direction is rounding
    for (const std::uint32_t v : t) worst = std::min(worst, facet.normalized().dot(vec3(mesh.normals[v])));
  }
  return worst;
}

// Normals turn as the surface does, also in charts that are mirrored.
TEST(TiledPatch, NormalsAreThoseOfTheRelief) {
  const PatchGeometry patch = bumps(24);
  const double length = 2 * kPi * kRadius, worst = worstNormal(patch.mesh);
  ASSERT_GT(worst, 0.7);
  for (const bool mirrored : {false, true})
    EXPECT_NEAR(worstNormal(laid(patch, plane(3, mirrored), 0.5)), worst, 1e-3) << mirrored;
  EXPECT_NEAR(worstNormal(laid(patch, cylinder(40), length / 6)), worst, 0.06);
}

// Seen from the right half of a bump that falls to the right, in a chart that is mirrored too.
TEST(TiledPatch, MirroredChartsMirrorTheRelief) {
  const PatchGeometry patch =
      tests::heightPatch(16, 0.2, [](double x, double) { return x < 0.5 ? 2 * x : 1.0; });
  for (const bool mirrored : {false, true}) {
    const TriangleMesh mesh = laid(patch, plane(3, mirrored), 3);
    for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
      const double u = mirrored ? 3 - mesh.positions[v][0] : mesh.positions[v][0];
      if (u < 0.3 || u > 1.2) continue;  // of the ramp that rises along u
      EXPECT_EQ(mesh.normals[v][0] < 0, !mirrored);
      EXPECT_GT(mesh.normals[v][1], 0);
    }
  }
}

// A weave's threads reach beyond the period and over each other.
TEST(TiledPatch, OverhangsAreKept) {
  const PatchGeometry patch = tests::dimple(0.25, 0.2, 24, {1, 1, 1});
  const TriangleMesh mesh = laid(patch, plane(3), 1);
  EXPECT_NEAR(tests::surfaceArea(mesh), 9 * tests::surfaceArea(patch.mesh), 1e-3);
  EXPECT_EQ(openEdges(mesh,
                      [](const Vec3& p) {
                        return p.x() > 1e-3 && p.x() < 3 - 1e-3 && p.z() < -1e-3 && p.z() > -3 + 1e-3;
                      }),
            0);
}

TEST(TiledPatch, RefusesWhatItCannotLay) {
  TriangleMesh bare = plane(1);
  bare.texcoords.clear();
  EXPECT_THROW(tiled(bumps(), bare, {}, "bare.ply"), Error);
  TriangleMesh dull = plane(1);
  dull.normals.clear();
  EXPECT_THROW(tiled(bumps(), dull, {}, "dull.ply"), Error);
  EXPECT_THROW(tiled(bumps(), plane(1), {1e5, 1e-5}, "tiny.ply"), Error);
  TriangleMesh folded = plane(1);
  folded.texcoords.assign(folded.vertexCount(), {0.5F, 0.5F});
  EXPECT_EQ(tiled(bumps(), folded, {}, "").bare_triangles, 18);
}

}  // namespace
}  // namespace bakelight::patch
