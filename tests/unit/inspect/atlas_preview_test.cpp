#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "formats/error.h"
#include "tests/unit/inspect/texcoord_meshes.h"
#include "tools/inspect/colormap.h"
#include "tools/inspect/preview.h"

namespace bakelight::inspect {
namespace {

using formats::Image;
using formats::TriangleMesh;
using testing::HasSubstr;
using tests::appendSquare;
using tests::texturedSquare;

DisplayColor pixel(const Image& image, int x, int y) {
  return {image.texel(x, y)[0], image.texel(x, y)[1], image.texel(x, y)[2]};
}

double difference(const DisplayColor& a, const DisplayColor& b) {
  double sum = 0;
  for (std::size_t c = 0; c < 3; ++c) sum += std::abs(a[c] - b[c]);
  return sum;
}

PreviewOptions square(Paint paint) {
  PreviewOptions options;
  options.size_px = 64;
  options.layout = Layout::kAtlas;
  options.paint = paint;
  return options;
}

TEST(AtlasPreview, TheUnitSquareHasItsOriginAtTheLowerLeft) {
  const Preview preview = previewAtlas(texturedSquare({0, 0}, {0.5f, 0.25f}), square(Paint::kAutomatic), "");
  ASSERT_EQ(preview.image.width, 64);
  ASSERT_EQ(preview.image.height, 64);
  const DisplayColor paper = pixel(preview.image, 60, 4);
  // The chart covers columns 0–31 of the lowest 16 rows; away from its borders and the diagonal it is plain.
  EXPECT_LT(difference(pixel(preview.image, 8, 52), chartColor(0)), 0.02);
  EXPECT_LT(difference(pixel(preview.image, 24, 59), chartColor(0)), 0.02);
  for (const auto& [x, y] : {std::pair{8, 44}, {36, 52}, {8, 8}, {60, 60}})
    EXPECT_EQ(pixel(preview.image, x, y), paper) << x << ", " << y;
  // Its border is drawn, the diagonal lightly.
  const auto darkness = [&](int x, int y) { return chartColor(0)[0] - pixel(preview.image, x, y)[0]; };
  EXPECT_GT(darkness(12, 48), 0.2);
  EXPECT_GT(darkness(16, 55), 0.02);
  EXPECT_LT(darkness(16, 55), darkness(12, 48));
}

TEST(AtlasPreview, StretchIsBlueWithMuchTextureAndRedWithLittle) {
  TriangleMesh mesh = texturedSquare({0, 0}, {0.5f, 0.5f});
  appendSquare(mesh, {3, 0, 0}, 1, {0.5f, 0.5f}, {0.75f, 0.75f});
  const Preview preview = previewAtlas(mesh, square(Paint::kStretch), "");
  const DisplayColor much = pixel(preview.image, 8, 44), little = pixel(preview.image, 43, 27);
  EXPECT_GT(much[2], much[0] + 0.2f);
  EXPECT_GT(little[0], little[2] + 0.2f);
  EXPECT_THAT(preview.caption, HasSubstr("red is 1.58"));  // 4 √(5/32)
  const Preview even = previewAtlas(texturedSquare({0, 0}, {1, 1}), square(Paint::kStretch), "");
  for (const float value : pixel(even.image, 16, 40)) EXPECT_GT(value, 0.99f);
}

TEST(AtlasPreview, ATriangleWithoutTextureIsMagentaOnTheModel) {
  TriangleMesh mesh = texturedSquare({0, 0}, {0.5f, 0.5f});
  mesh.texcoords[3] = {0.25f, 0.25f};
  PreviewOptions options;
  options.size_px = 33;
  options.yaw_deg = options.pitch_deg = 0;
  options.paint = Paint::kStretch;
  const Preview preview = previewAtlas(mesh, options, "");
  const DisplayColor upper_left = pixel(preview.image, 13, 13);
  EXPECT_GT(upper_left[0], upper_left[1] + 0.3f);
  EXPECT_GT(upper_left[2], upper_left[1] + 0.3f);
}

TEST(AtlasPreview, ChartsOnTheModelHaveTheirColorsAndADarkLineBetween) {
  TriangleMesh mesh = texturedSquare({0, 0}, {0.4f, 0.4f});
  appendSquare(mesh, {1, 0, 0}, 1, {0.5f, 0.5f}, {0.9f, 0.9f});
  PreviewOptions options;
  options.size_px = 65;
  options.yaw_deg = options.pitch_deg = 0;
  options.paint = Paint::kCharts;
  const Image image = previewAtlas(mesh, options, "").image;
  const DisplayColor left = pixel(image, 26, 32), right = pixel(image, 38, 32), middle = pixel(image, 32, 32);
  EXPECT_GT(difference(left, right), 0.3);
  const auto sum = [](const DisplayColor& color) { return color[0] + color[1] + color[2]; };
  EXPECT_LT(sum(middle), 0.6 * std::min(sum(left), sum(right)));
}

TEST(AtlasPreview, MaterialsHaveTheirColorsWithOrWithoutTexcoords) {
  TriangleMesh mesh = texturedSquare({0, 0}, {0.4f, 0.4f});
  appendSquare(mesh, {1, 0, 0}, 1, {0.5f, 0.5f}, {0.9f, 0.9f});
  PreviewOptions options;
  options.size_px = 65;
  options.yaw_deg = options.pitch_deg = 0;
  options.paint = Paint::kMaterials;
  EXPECT_THROW(previewMaterials(mesh, options, "plain.ply"), Error);
  mesh.triangle_materials = {0, 0, 1, 1};
  mesh.material_names = {"left", "right"};
  options.layout = Layout::kAtlas;
  const Image atlas = previewAtlas(mesh, options, "").image;
  EXPECT_LT(difference(pixel(atlas, 20, 60), chartColor(0)), 0.02);
  EXPECT_LT(difference(pixel(atlas, 37, 12), chartColor(1)), 0.02);
  options.layout = Layout::kModel;
  mesh.texcoords.clear();
  const Preview preview = previewMaterials(mesh, options, "");
  EXPECT_THAT(preview.caption, HasSubstr("2 materials"));
  const DisplayColor left = pixel(preview.image, 26, 32), right = pixel(preview.image, 38, 32),
                     middle = pixel(preview.image, 32, 32);
  EXPECT_GT(difference(left, right), 0.3);
  const auto sum = [](const DisplayColor& color) { return color[0] + color[1] + color[2]; };
  EXPECT_LT(sum(middle), 0.6 * std::min(sum(left), sum(right)));
}

TEST(AtlasPreview, WithoutPaintTheModelIsClayAndTheAtlasPlain) {
  EXPECT_FALSE(PreviewOptions{}.showsTexcoords());
  EXPECT_TRUE(square(Paint::kNone).showsTexcoords());
  const Image image = previewAtlas(texturedSquare({0, 0}, {1, 1}), square(Paint::kNone), "").image;
  const DisplayColor plain = pixel(image, 16, 40);
  EXPECT_EQ(plain[0], plain[1]);
  EXPECT_EQ(plain[1], plain[2]);
}

TEST(AtlasPreview, AMeshWithoutTexcoordsIsAnError) {
  TriangleMesh mesh = texturedSquare({0, 0}, {1, 1});
  mesh.texcoords.clear();
  try {
    previewAtlas(mesh, square(Paint::kAutomatic), "plain.ply");
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("plain.ply"));
    EXPECT_THAT(error.what(), HasSubstr("no texture coordinates"));
  }
}

TEST(AtlasPreview, EveryChoiceHasAWord) {
  EXPECT_THAT(formats::textsOf(kPaints),
              testing::ElementsAre("auto", "none", "charts", "stretch", "materials", "colors", "patch",
                                   "tangents", "coherence"));
  EXPECT_THAT(formats::textsOf(kLayouts), testing::ElementsAre("model", "atlas"));
  EXPECT_STREQ(formats::wordFor(kPaints, Paint::kStretch), "stretch");
}

TEST(Colormap, ChartColorsAreFarApart) {
  for (std::uint32_t i = 0; i < kChartColors; ++i)
    for (std::uint32_t j = 0; j < i; ++j)
      EXPECT_GT(difference(chartColor(i), chartColor(j)), 0.15) << i << " " << j;
}

}  // namespace
}  // namespace bakelight::inspect
