// Patches of materials as geometry, for the path tracer.
#include "tools/reference/patch_surface.h"

#include <gtest/gtest.h>

#include <fstream>
#include <optional>

#include "tests/support/temporary_folder.h"
#include "tests/unit/reference/scenes.h"
#include "transport/texture_frames.h"

namespace bakelight::tests {
namespace {

using namespace reference;

// 2 × 2, facing +y; u along +x, v along −z. Its halves left and right have materials of their own.
TriangleMesh floorOfTwo() {
  TriangleMesh mesh;
  for (const float x : {-1.0F, 0.0F, 0.0F, 1.0F})
    for (const float z : {1.0F, -1.0F}) {
      mesh.positions.push_back({x, 0, z});
      mesh.normals.push_back({0, 1, 0});
      mesh.texcoords.push_back({(x + 1) / 2, (1 - z) / 2});
    }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 6, 7}, {4, 7, 5}};
  mesh.triangle_materials = {0, 0, 1, 1};
  mesh.material_names = {"left", "right"};
  return mesh;
}

class Patched {
 public:
  Patched() {
    formats::Image flat(2, 2, {"Y"});
    flat.values.assign(4, 0.5F);
    formats::writeExr(folder_ / "flat.exr", flat);
    formats::Image pit(8, 8, {"Y"});
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) pit.texel(x, y)[0] = x > 1 && x < 6 && y > 1 && y < 6 ? 0.0F : 1.0F;
    formats::writeExr(folder_ / "pit.exr", pit);
    formats::Image halves(8, 8, {"R", "G", "B"});
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) std::fill_n(halves.texel(x, y), 3, x < 4 ? 0.2F : 0.8F);
    formats::writeExr(folder_ / "halves.exr", halves);
  }

  PatchedSurface of(const TriangleMesh& mesh, const std::string& json) const {
    std::ofstream(folder_ / "material.json") << json;
    const formats::Materials materials = formats::readMaterials(folder_ / "material.json");
    EXPECT_TRUE(hasPatches(materials));
    Surface surface{mesh, formats::materialsOn(mesh, materials, "mesh", "material")};
    return withPatches(surface, materials, "mesh.ply");
  }

 private:
  TemporaryFolder folder_;
};

// From above, at x and z.
std::optional<ShadingPoint> pointBelow(const Scene& scene, double x, double z) {
  const transport::Hit hit = scene.rays().nearestHit(Vec3(x, 5, z), Vec3(0, -1, 0));
  if (!hit.valid) return std::nullopt;
  return scene.pointAt(hit);
}

TEST(PatchedSurface, FlatPatchesAreTheSurface) {
  const PatchedSurface patched =
      Patched().of(floorOfTwo(), R"({"albedo": [0.5, 0.25, 1], "patch": {"height": {"file": "flat.exr"}}})");
  EXPECT_NEAR(surfaceArea(patched.surface.mesh), 4, 1e-5);
  EXPECT_TRUE(patched.notes.empty());
  const Scene scene = sceneOf(patched.surface, uniformRig());
  const auto point = pointBelow(scene, 0.3, 0.4);
  ASSERT_TRUE(point);
  EXPECT_NEAR(point->origin.y(), 0, 1e-3);
  EXPECT_NEAR(point->normal.y(), 1, 1e-6);
  EXPECT_TRUE(point->albedo.isApprox(Rgb(0.5, 0.25, 1), 1e-6));
}

// A texture over a patch, 0.5 wide: its left quarter of a unit is dark, the next bright.
TEST(PatchedSurface, TexturesRepeatWithThePatch) {
  const PatchedSurface patched = Patched().of(
      floorOfTwo(),
      R"({"patch": {"height": {"file": "flat.exr"}, "texture": {"file": "halves.exr"}, "albedo": [1, 0.5, 1], "width": 0.5}})");
  const Scene scene = sceneOf(patched.surface, uniformRig());
  for (const double x : {-0.875, -0.375, 0.125, 0.625}) {
    const auto dark = pointBelow(scene, x, 0.3), bright = pointBelow(scene, x + 0.25, 0.3);
    ASSERT_TRUE(dark && bright);
    EXPECT_NEAR(dark->albedo[0], 0.2, 1e-2);
    EXPECT_NEAR(dark->albedo[1], 0.1, 1e-2);
    EXPECT_NEAR(bright->albedo[0], 0.8, 1e-2);
  }
}

// A wide pit 0.25 deep, whose middle is at its bottom, half of the depth below the surface; on faces of its material alone.
TEST(PatchedSurface, StandsOnFacesOfItsMaterial) {
  const PatchedSurface patched = Patched().of(floorOfTwo(), R"({
    "material": {"albedo": [0.9, 0.9, 0.9]},
    "materials": {"left": {"albedo": [0.5, 0.5, 0.5],
                           "patch": {"height": {"file": "pit.exr", "depth": 0.25}, "width": 1}}}})");
  const Scene scene = sceneOf(patched.surface, uniformRig());
  const auto pit = pointBelow(scene, -0.5, 0.5), floor = pointBelow(scene, 0.5, 0.5);
  ASSERT_TRUE(pit && floor);
  EXPECT_NEAR(pit->origin.y(), -0.125, 2e-3);
  EXPECT_NEAR(pit->albedo[0], 0.5, 1e-6);
  EXPECT_NEAR(floor->origin.y(), 0, 2e-3);
  EXPECT_NEAR(floor->albedo[0], 0.9, 1e-6);
  // Walls hide part of the sky: darker than the open floor of the same albedo, less so with bounces.
  const auto direct = estimate(scene, {.transport = Transport::kShadowed}, *pit, pit->normal, 64),
             all = estimate(scene, {}, *pit, pit->normal, 64);
  EXPECT_LT(direct.luminance(), 0.45);
  EXPECT_GT(all.luminance(), direct.luminance() + 3 * standardError(all));
}

TEST(PatchedSurface, IsAsWideAsPacksHaveIt) {
  const TriangleMesh mesh = floorOfTwo();
  ASSERT_NEAR(transport::surfaceUnitOf(mesh), 2, 1e-6);
  // Once over the texture, at a depth in proportion: the pit's bottom under the middle.
  const PatchedSurface patched =
      Patched().of(mesh, R"({"patch": {"height": {"file": "pit.exr", "depth": 0.25}}})");
  const Scene scene = sceneOf(patched.surface, uniformRig());
  const auto pit = pointBelow(scene, -0.1, 0.2);
  ASSERT_TRUE(pit);
  EXPECT_NEAR(pit->origin.y(), -0.25, 2e-3);
}

TEST(PatchedSurface, TellsWhereItIsCut) {
  TriangleMesh mesh = floorOfTwo();
  for (std::size_t v = 4; v < 8; ++v) mesh.texcoords[v][0] += 0.1F;
  const std::string json = R"({"patch": {"height": {"file": "pit.exr"}, "width": 1}})";
  const PatchedSurface patched = Patched().of(mesh, json);
  ASSERT_EQ(patched.notes.size(), 1);
  EXPECT_NE(patched.notes.front().find("cut at 1 edges"), std::string::npos);
}

TEST(PatchedSurface, RefusesAMeshWithoutTextureCoordinates) {
  TriangleMesh mesh = floorOfTwo();
  mesh.texcoords.clear();
  EXPECT_THROW(Patched().of(mesh, R"({"patch": {"height": {"file": "pit.exr"}}})"), Error);
}

}  // namespace
}  // namespace bakelight::tests
