// Surfaces of patches: height fields and meshes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "formats/error.h"
#include "patch/creased_normals.h"
#include "patch/periodic_places.h"
#include "patch/read_patch.h"
#include "patch/subdivision.h"
#include "tests/support/patches.h"
#include "transport/vector_types.h"

namespace bakelight::patch {
namespace {

using formats::TriangleMesh;
using testing::HasSubstr;
using transport::vec3;

double areaOf(const TriangleMesh& mesh) {
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles)
    area += (vec3(mesh.positions[b]) - vec3(mesh.positions[a]))
                .cross(vec3(mesh.positions[c]) - vec3(mesh.positions[a]))
                .norm() /
            2;
  return area;
}

TEST(HeightField, StandsAboutItsMidPlane) {
  // Upper left is high.
  const formats::Image heights =
      tests::heightsOf(8, 4, [](double x, double y) { return x < 0.5 && y > 0.5 ? 0.75 : 0.25; });
  const PatchGeometry geometry = heightField(heights, 0.4, true, "h.png");
  EXPECT_EQ(geometry.aspect, 0.5);
  EXPECT_EQ(geometry.period_x, 1);
  EXPECT_EQ(geometry.period_y, 0.5);
  float low = 1, high = -1;
  for (const Float3& p : geometry.mesh.positions) {
    low = std::min(low, p[2]), high = std::max(high, p[2]);
    const bool is_upper_left = p[0] < 0.5F && p[1] > 0.25F && p[1] < 0.5F;
    if (p[0] < 1 && p[1] < 0.5F) {
      EXPECT_FLOAT_EQ(p[2], is_upper_left ? 0.1F : -0.1F);
    }
  }
  EXPECT_FLOAT_EQ(low, -0.1F);
  EXPECT_FLOAT_EQ(high, 0.1F);
}

// One period of triangles, each place's normal the same on both sides of the seam.
TEST(HeightField, FitsItselfAcrossTheSeam) {
  const PatchGeometry geometry = tests::heightPatch(16, 0.2, tests::waves);
  EXPECT_EQ(geometry.mesh.triangleCount(), 2U * 16 * 16);
  const std::vector<std::uint32_t> places = periodicPlaces(geometry.mesh, 1, 1);
  int shared = 0;
  for (std::uint32_t v = 0; v < places.size(); ++v) {
    if (places[v] == v) continue;
    ++shared;
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(geometry.mesh.normals[v][c], geometry.mesh.normals[places[v]][c], 1e-4);
  }
  EXPECT_EQ(shared, 2 * 16 + 1);
}

TEST(HeightField, MirrorImagesContinueWhatDoesNotContinueItself) {
  const formats::Image ramp = tests::heightsOf(8, 8, [](double x, double) { return x; });
  const PatchGeometry geometry = heightField(ramp, 1, false, "ramp.png");
  EXPECT_TRUE(geometry.mirrored());
  EXPECT_EQ(geometry.period_x, 2);
  EXPECT_NEAR(areaOf(geometry.mesh), 4 * (7.0 / 8 * std::sqrt(2) + 1.0 / 8),
              1e-4);  // without a wall at the seam
}

TEST(HeightField, RefusesWhatIsNone) {
  const formats::Image huge = tests::heightsOf(2, 2, [](double, double) { return 1e9; });
  try {
    heightField(huge, 1, true, "h.exr");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("h.exr"));
    EXPECT_THAT(error.what(), HasSubstr("texel (0, 1)"));
  }
}

TEST(CreasedNormals, PartFacetsAtEdgesOnly) {
  const auto step = [](double x, double) { return x < 0.5 ? 0.0 : 1.0; };
  const PatchGeometry cliff = tests::heightPatch(16, 1, step), slope = tests::heightPatch(16, 0.02, step);
  std::size_t straight = 0;
  for (const Float3& n : cliff.mesh.normals) straight += n[2] > 0.999F || n[2] < 0.1F ? 1 : 0;
  EXPECT_EQ(straight, cliff.mesh.vertexCount());
  EXPECT_GT(cliff.mesh.vertexCount(), slope.mesh.vertexCount());
}

formats::TriangleMesh plate(double width, double height) {
  TriangleMesh mesh;
  const auto w = static_cast<float>(width), h = static_cast<float>(height);
  mesh.positions = {{3, 5, 1}, {3 + w, 5, 1}, {3 + w, 5 + h, 2}, {3, 5 + h, 2}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

TEST(MeshPatch, IsScaledToItsPeriod) {
  const PatchGeometry own = meshPatch(plate(4, 2), {}, true, "m.ply");
  EXPECT_FLOAT_EQ(static_cast<float>(own.aspect), 0.5F);
  EXPECT_EQ(own.mesh.positions[2], (Float3{1, 0.5F, 0.125F}));
  formats::PatchMesh wider;
  wider.period = {8, 4};
  EXPECT_EQ(meshPatch(plate(4, 2), wider, true, "m.ply").mesh.positions[2], (Float3{0.5F, 0.25F, 0.0625F}));
  formats::PatchMesh upright;
  upright.up = formats::PatchMesh::Up::kY;
  // +Y is out of the patch: what was z goes downwards.
  EXPECT_EQ(meshPatch(plate(4, 2), upright, true, "m.ply").mesh.positions[2], (Float3{1, 0, 0.25F}));
}

TEST(MeshPatch, RefusesWhatHasNoExtent) {
  for (const TriangleMesh& mesh : {plate(0, 2), TriangleMesh{}}) {
    EXPECT_THROW(meshPatch(mesh, {}, true, "m.ply"), Error);
  }
  formats::PatchMesh tiny;
  tiny.period = {0.5, 0.5};
  try {
    meshPatch(plate(4, 2), tiny, true, "m.ply");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("period"));
  }
}

TEST(Subdivision, KeepsTheSurfaceAndBoundsItsEdges) {
  const PatchGeometry geometry = tests::heightPatch(4, 0.5, tests::waves);
  const TriangleMesh finer = subdivided(geometry.mesh, 0.05);
  EXPECT_NEAR(areaOf(finer), areaOf(geometry.mesh), 1e-5);
  for (const auto& t : finer.triangles)
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_LE((vec3(finer.positions[t[i]]) - vec3(finer.positions[t[(i + 1) % 3]])).norm(), 0.0501);
  for (const Float3& n : finer.normals) EXPECT_NEAR(vec3(n).norm(), 1, 1e-5);
  EXPECT_EQ(subdivided(finer, 0.05).triangleCount(), finer.triangleCount());
}

TEST(PatchGeometry, AlbedoIsColorTimesTextureTimesAlbedo) {
  PatchGeometry geometry = tests::flatPatch({0.5F, 1, 1});
  geometry.texture = formats::Image(2, 1, {"R", "G", "B"});
  geometry.texture.values = {1, 1, 1, 0, 0.5F, 1};
  EXPECT_EQ(geometry.textureAt(0.25, 0.5), (Float3{1, 1, 1}));
  EXPECT_EQ(geometry.textureAt(0.75, 0.5), (Float3{0, 0.5F, 1}));
  EXPECT_FLOAT_EQ(geometry.textureAt(0, 0.5)[0], 0.5F);  // around the seam
  geometry.mesh.colors.assign(geometry.mesh.vertexCount(), {0.5F, 0.5F, 0.5F});
  EXPECT_EQ(geometry.albedoOfVertex(0)[1], 0.5F * geometry.textureAt(0.125, 0.125)[1]);
}

}  // namespace
}  // namespace bakelight::patch
