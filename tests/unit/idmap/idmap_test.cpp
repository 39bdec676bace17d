// The id map of an atlas: every texel shows its surface's place, gutters copy, blocks and threads leave no trace.
#include "tools/idmap/idmap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "formats/error.h"
#include "formats/image.h"
#include "tests/support/shapes.h"
#include "tests/support/temporary_folder.h"
#include "tools/atlas/make_atlas.h"
#include "tools/atlas/maps/geometry_maps.h"
#include "tools/idmap/triangle_materials.h"
#include "transport/vector_types.h"

namespace bakelight::idmap {
namespace {

using formats::TriangleMesh;
using testing::HasSubstr;
using transport::Vec3;
using transport::vec3;

enum { kU, kV, kMaterial, kVertex, kCoverage };

class IdMapTest : public testing::Test {
 protected:
  static constexpr int kResolution = 100;  // no multiple of a tile or of a block of rows

  // Made once.
  struct Ball {
    atlas::Atlas atlas;
    formats::Image maps;
  };
  static const Ball& ball() {
    static const Ball made = [] {
      atlas::AtlasOptions options;
      options.resolution = kResolution;
      atlas::Atlas atlas = atlas::makeAtlas(tests::icosphere(3), {}, options, "ball").atlas;
      formats::Image maps = atlas::geometryMaps(atlas, {kResolution, 2}, "ball");
      return Ball{std::move(atlas), std::move(maps)};
    }();
    return made;
  }

  IdMapTest() : made_(ball().atlas), maps_(ball().maps) {
    write();
    for (std::size_t v = 0; v < meso_.vertexCount(); ++v)
      patch_.push_back({static_cast<float>(v % 100) / 100, static_cast<float>(v % 64) / 64});
  }

  void write() { formats::writeExr(file_, maps_, formats::ExrPrecision::kFloat); }
  IdMap make(const IdMapOptions& options = {}) const {
    return makeIdMap({{meso_, materials_}, patch_}, file_, options, [](std::size_t) {});
  }
  std::string problem(const IdMapOptions& options = {}) const {
    try {
      make(options);
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  }
  float map(int x, int y, const char* channel) const {
    return maps_.texel(x, y)[maps_.channelIndex(channel)];
  }

  tests::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "maps.exr";
  TriangleMesh meso_ = tests::icosphere(5);
  std::vector<Float2> patch_;
  std::vector<std::uint32_t> materials_;
  atlas::Atlas made_;
  formats::Image maps_;
};

TEST_F(IdMapTest, EveryTexelShowsAVertexOnItsLine) {
  const IdMap ids = make();
  std::int64_t covered = 0;
  for (int y = 0; y < kResolution; ++y)
    for (int x = 0; x < kResolution; ++x) {
      const std::uint32_t* id = ids.image.texel(x, y);
      EXPECT_EQ(static_cast<float>(id[kCoverage]), map(x, y, "coverage"));
      if (id[kCoverage] == 0) continue;
      ++covered;
      const Vec3 normal(map(x, y, "normal.X"), map(x, y, "normal.Y"), map(x, y, "normal.Z"));
      const Vec3 way = vec3(meso_.positions[id[kVertex]]) -
                       Vec3(map(x, y, "position.X"), map(x, y, "position.Y"), map(x, y, "position.Z"));
      // An icosphere of five subdivisions has edges of about 0.035.
      EXPECT_LT((way - way.dot(normal) * normal).norm(), 0.03) << x << ' ' << y;
      EXPECT_EQ(id[kU], std::round(patch_[id[kVertex]][0] * kPatchSteps));
      EXPECT_EQ(id[kV], std::round(patch_[id[kVertex]][1] * kPatchSteps));
    }
  EXPECT_GT(covered, kResolution * kResolution / 3);
  EXPECT_EQ(ids.covered, covered);
  EXPECT_EQ(ids.filled, kResolution * kResolution - covered);
}

TEST_F(IdMapTest, GuttersAreCopiesOfTheNearestTexel) {
  const IdMap ids = make();
  std::int64_t checked = 0;
  for (int y = 0; y < kResolution; y += 2)
    for (int x = 0; x < kResolution; x += 2) {
      const std::uint32_t* id = ids.image.texel(x, y);
      if (id[kCoverage] != 0) continue;
      int nearest = kResolution * kResolution * 2;
      for (int j = 0; j < kResolution; ++j)
        for (int i = 0; i < kResolution; ++i)
          if (ids.image.texel(i, j)[kCoverage] != 0)
            nearest = std::min(nearest, (i - x) * (i - x) + (j - y) * (j - y));
      bool is_copy = false;
      const int reach = static_cast<int>(std::sqrt(nearest)) + 1;
      for (int j = std::max(0, y - reach); j <= std::min(kResolution - 1, y + reach); ++j)
        for (int i = std::max(0, x - reach); i <= std::min(kResolution - 1, x + reach); ++i)
          is_copy = is_copy || ((i - x) * (i - x) + (j - y) * (j - y) == nearest &&
                                ids.image.texel(i, j)[kCoverage] != 0 &&
                                std::equal(id, id + kCoverage, ids.image.texel(i, j)));
      EXPECT_TRUE(is_copy) << x << ' ' << y;
      ++checked;
    }
  EXPECT_GT(checked, 50);
}

TEST_F(IdMapTest, IsTheSameOnAnyNumberOfThreads) {
  const IdMap many = make();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(make().image.values, many.image.values);
}

TEST_F(IdMapTest, TexelsKeepToTheirMaterial) {
  for (const formats::Float3& p : meso_.positions) materials_.push_back(p[1] > 0 ? 7 : 3);
  std::vector<std::uint32_t> of_triangles;
  for (const formats::Triangle& t : made_.mesh.triangles)
    of_triangles.push_back(made_.mesh.positions[t[0]][1] + made_.mesh.positions[t[1]][1] > 0 ? 7 : 3);
  const IdMap ids = make({.triangle_materials = of_triangles});
  EXPECT_LT(ids.moved, 100);
  for (int y = 0; y < kResolution; ++y)
    for (int x = 0; x < kResolution; ++x)
      if (ids.image.texel(x, y)[kCoverage] != 0) {
        EXPECT_EQ(ids.image.texel(x, y)[kMaterial],
                  of_triangles[static_cast<std::size_t>(map(x, y, "triangle"))]);
      }
  EXPECT_THAT(problem({.triangle_materials = std::span(of_triangles).first(5)}), HasSubstr("names triangle"));
}

TEST_F(IdMapTest, ASurfaceThatFacesTheOtherWayIsRefused) {
  meso_ = tests::insideOut(meso_);
  EXPECT_THAT(problem(), testing::AllOf(HasSubstr("texel ("), HasSubstr("faces the same way")));
}

TEST_F(IdMapTest, AnotherSurfaceIsWarnedOf) {
  EXPECT_EQ(warningOf(make(), meso_), "");
  for (formats::Float3& p : meso_.positions) p[0] += 0.5F;
  EXPECT_THAT(warningOf(make(), meso_), HasSubstr("hardly of its surface"));
}

TEST_F(IdMapTest, MapsWithoutTheirChannelsAreRefused) {
  maps_.channel_names[static_cast<std::size_t>(maps_.channelIndex("normal.Y"))] = "normal.W";
  write();
  EXPECT_THAT(problem(), HasSubstr("channel normal.Y"));
  maps_ = formats::Image(4, 4, maps_.channel_names);
  maps_.channel_names[static_cast<std::size_t>(maps_.channelIndex("normal.W"))] = "normal.Y";
  write();
  EXPECT_THAT(problem(), HasSubstr("no texel is covered"));
}

TEST(TriangleMaterials, GoByName) {
  TriangleMesh mesh = tests::icosphere(0);
  mesh.triangle_materials.assign(20, 1);
  mesh.triangle_materials[3] = 0;
  mesh.material_names = {"wood", "wool"};
  const auto found = triangleMaterials(mesh, "atlas.ply", {"wool", "stone", "wood"}, "meso.ply");
  EXPECT_EQ(found[0], 0u);
  EXPECT_EQ(found[3], 2u);
  EXPECT_TRUE(triangleMaterials(mesh, "atlas.ply", {}, "meso.ply").empty());
  try {
    triangleMaterials(mesh, "atlas.ply", {"wool"}, "meso.ply");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::AllOf(HasSubstr("face 3"), HasSubstr("wood")));
  }
}

TEST(TriangleMaterials, OfOneNameAreToldApartByTheirPlace) {
  TriangleMesh mesh = tests::icosphere(0);
  mesh.triangle_materials.assign(20, 1);
  mesh.material_names = {"", ""};
  EXPECT_EQ(triangleMaterials(mesh, "a", {"", ""}, "b")[0], 1u);
}

}  // namespace
}  // namespace bakelight::idmap
