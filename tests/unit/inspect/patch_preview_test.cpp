// Pictures and figures of meso-meshes and id maps.
#include "tools/inspect/patch_preview.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "formats/error.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/inspect/texcoord_meshes.h"
#include "tools/inspect/direction_strokes.h"
#include "tools/inspect/inspect.h"

namespace bakelight::inspect {
namespace {

using formats::Float2;
using formats::Float3;
using formats::IndexImage;
using formats::MesoMesh;
using testing::HasSubstr;

constexpr int kSide = 12;
constexpr float kWidth = 0.5F;  // of the patch

// A square of the x–y plane that faces +Z and shows a patch as it is; `tangent(x, y)` of each vertex.
template <class Tangent>
MesoMesh square(const Tangent& tangent) {
  MesoMesh meso;
  for (int j = 0; j <= kSide; ++j)
    for (int i = 0; i <= kSide; ++i) {
      const double x = static_cast<double>(i) / kSide - 0.5, y = static_cast<double>(j) / kSide - 0.5;
      meso.mesh.positions.push_back({static_cast<float>(x), static_cast<float>(y), 0});
      meso.mesh.normals.push_back({0, 0, 1});
      meso.tangents.push_back(tangent(x, y));
      const auto place = [](double at) {
        return static_cast<float>((at + 1) / kWidth - std::floor((at + 1) / kWidth));
      };
      meso.patch.push_back({place(x), place(y)});
      meso.materials.push_back(0);
    }
  const auto at = [](int i, int j) { return static_cast<std::uint32_t>(j * (kSide + 1) + i); };
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      meso.mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      meso.mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return meso;
}

MesoMesh plain() {
  return square([](double, double) { return Float3{1, 0, 0}; });
}

// Directions that turn `turns` times around a point.
MesoMesh turning(double turns, int symmetry) {
  MesoMesh meso = square([&](double x, double y) {
    const double angle = turns * std::atan2(y - 0.03, x - 0.04);
    return Float3{static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0};
  });
  meso.symmetry = symmetry;
  return meso;
}

TEST(TurningTriangles, CountTurnsInPartsOfTheSymmetry) {
  EXPECT_TRUE(turningTriangles(plain()).empty());
  for (const auto& [turns, symmetry, index] :
       {std::tuple(1.0, 1, 1), {-1.0, 1, -1}, {0.5, 2, 1}, {-0.5, 2, -1}, {0.25, 4, 1}, {-0.25, 4, -1}}) {
    const std::vector<TurningTriangle> found = turningTriangles(turning(turns, symmetry));
    ASSERT_EQ(found.size(), 1u) << turns;
    EXPECT_EQ(found[0].index, index) << turns;
  }
}

TEST(Coherence, IsWholeForATiling) {
  for (const float share : coherenceOf(plain())) EXPECT_EQ(share, 1);
}

TEST(Coherence, IsLessAlongACut) {
  MesoMesh meso = plain();
  for (std::size_t v = 0; v < meso.patch.size(); ++v)
    if (meso.mesh.positions[v][0] > 0.01F) meso.patch[v][1] = std::fmod(meso.patch[v][1] + 0.37F, 1.0F);
  const std::vector<float> shares = coherenceOf(meso);
  const auto at = [&](int i, int j) { return shares[static_cast<std::size_t>(j * (kSide + 1) + i)]; };
  EXPECT_LT(at(kSide / 2, 5), 0.8F);
  EXPECT_EQ(at(2, 5), 1);
  EXPECT_EQ(at(10, 5), 1);
}

TEST(MesoMeshPreview, ShowsPlacesAndRefusesWhatThereIsNot) {
  PreviewOptions options;
  options.size_px = 64, options.yaw_deg = 0, options.pitch_deg = 0, options.paint = Paint::kPatch;
  const formats::Image image = previewMesoMesh(plain(), options, "m.ply").image;
  // Within a period u grows to the right, v upwards.
  const auto red = [&](int x, int y) { return image.texel(x, y)[0]; };
  const auto green = [&](int x, int y) { return image.texel(x, y)[1]; };
  EXPECT_GT(red(26, 26), red(18, 26) + 0.1F);
  EXPECT_GT(green(26, 18), green(26, 26) + 0.1F);
  for (const Paint paint : {Paint::kCoherence, Paint::kTangents}) {
    options.paint = paint;
    EXPECT_EQ(previewMesoMesh(plain(), options, "m.ply").image.width, 64);
  }
  options.paint = Paint::kColors;
  EXPECT_THROW(previewMesoMesh(plain(), options, "m.ply"), Error);
  options.paint = Paint::kCharts;
  EXPECT_THROW(previewMesoMesh(plain(), options, "m.ply"), Error);
}

TEST(MesoMeshPreview, StrokesFollowTheField) {
  PreviewOptions options;
  options.size_px = 128, options.yaw_deg = 0, options.pitch_deg = 0, options.paint = Paint::kTangents;
  // Along x there are dark rows with light ones between, along y dark columns.
  const auto contrast = [&](const MesoMesh& meso, bool of_rows) {
    const formats::Image image = previewMesoMesh(meso, options, "m.ply").image;
    double least = 1, most = 0;
    for (int a = 50; a < 78; ++a) {
      double sum = 0;
      for (int b = 40; b < 88; ++b) sum += of_rows ? image.texel(b, a)[1] : image.texel(a, b)[1];
      least = std::min(least, sum / 48), most = std::max(most, sum / 48);
    }
    return most - least;
  };
  MesoMesh lying = plain(), standing = square([](double, double) { return Float3{0, 1, 0}; });
  lying.symmetry = standing.symmetry = 2;
  EXPECT_GT(contrast(lying, true), 2 * contrast(lying, false));
  EXPECT_GT(contrast(standing, false), 2 * contrast(standing, true));
}

class IdMapPreview : public testing::Test {
 protected:
  IdMapPreview() {
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        std::uint32_t* id = ids_.texel(x, y);
        id[0] = static_cast<std::uint32_t>(8192 * x);
        id[1] = static_cast<std::uint32_t>(8192 * (7 - y));
        id[2] = x < 4 ? 0 : 2;
        id[3] = static_cast<std::uint32_t>(x + 8 * y);
        id[4] = y == 0 ? 0 : 1;
      }
    options_.size_px = 64, options_.yaw_deg = 0, options_.pitch_deg = 0;
  }

  IndexImage ids_{8, 8, {"patch.U", "patch.V", "material", "vertex", "coverage"}};
  PreviewOptions options_;
};

TEST_F(IdMapPreview, IsRedToTheRightAndGreenUpwardsAndDarkInGutters) {
  const formats::Image image = previewIdMap(ids_, options_).image;
  EXPECT_LT(image.texel(4, 30)[0], 0.05F);
  EXPECT_GT(image.texel(60, 30)[0], 0.8F);
  EXPECT_GT(image.texel(30, 12)[1], image.texel(30, 60)[1] + 0.5F);
  EXPECT_LT(image.texel(60, 2)[0], 0.7F * image.texel(60, 12)[0]);
}

TEST_F(IdMapPreview, IsFoundByItsChannelsAndDescribed) {
  const tests::TemporaryFolder folder;
  formats::writeIndexExr(folder.path() / "ids.exr", ids_);
  const Inspection inspection = inspectFile(folder.path() / "ids.exr", options_);
  EXPECT_EQ(inspection.summary.kind, "id_map");
  const formats::Json figures = asJson(inspection.summary);
  EXPECT_EQ(figures.at("size").at("covered_texels"), 56);
  EXPECT_EQ(figures.at("size").at("meso_vertices"), 56);
  EXPECT_EQ(figures.at("materials").size(), 2u);
  formats::writeExr(folder.path() / "other.exr", formats::Image(4, 4, {"R", "G", "B"}));
  EXPECT_EQ(inspectFile(folder.path() / "other.exr", {}).summary.kind, "image");
}

TEST_F(IdMapPreview, ShowsTheExemplarThroughTextureCoordinates) {
  const formats::TriangleMesh mesh = tests::texturedSquare({0, 0}, {1, 1});
  formats::Image exemplar(2, 2, {"R", "G", "B"});
  exemplar.texel(0, 0)[0] = exemplar.texel(1, 0)[1] = exemplar.texel(0, 1)[2] =
      1;  // red, green above; blue below
  options_.pitch_deg = 0;
  const formats::Image image = previewThroughIdMap(mesh, ids_, exemplar, options_, "m.ply").image;
  const auto brightest = [&](int x, int y) {
    const float* p = image.texel(x, y);
    return std::max_element(p, p + 3) - p;
  };
  EXPECT_EQ(brightest(24, 24), 0);
  EXPECT_EQ(brightest(40, 24), 1);
  EXPECT_EQ(brightest(24, 40), 2);
  formats::TriangleMesh bare = mesh;
  bare.texcoords.clear();
  EXPECT_THROW(previewThroughIdMap(bare, ids_, exemplar, options_, "m.ply"), Error);
}

}  // namespace
}  // namespace bakelight::inspect
