#include "tools/inspect/preview.h"

#include <cmath>

#include "formats/error.h"
#include "tests/support/pack_parts.h"
#include "transport/color.h"

namespace bakelight::inspect {
namespace {

using formats::ElementType;
using formats::Image;
using formats::Tensor;
using formats::TriangleMesh;
using ::testing::ElementsAre;
using ::testing::FloatNear;
using ::testing::HasSubstr;

std::vector<float> pixel(const Image& image, int x, int y) {
  return {image.texel(x, y), image.texel(x, y) + 3};
}

TriangleMesh square() {  // facing +Z
  TriangleMesh mesh;
  mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

formats::EncodedTable tableOf(std::size_t rows, float value) {
  return formats::encodeTable(std::vector<float>(rows, value), 1, formats::Precision::kFloat32, "test",
                              "table");
}

// Red; each vertex sees the mean of the light.
formats::Pack squarePack() {
  formats::Pack pack{.name = "square", .mesh = square()};
  pack.appearances[0].base_color = {1, 0, 0};
  pack.mesh.normals.assign(4, {0, 0, 1});
  pack.sh().order = 1;
  pack.sh().vectors = tableOf(4, 0.2820948f);  // y_00
  return pack;
}

formats::TensorFile table(std::vector<float> values, std::uint64_t rows, std::uint64_t columns) {
  formats::TensorFile file;
  file.tensors["transfer"] = Tensor::from<float>(ElementType::kFloat32, {rows, columns}, values);
  return file;
}

TEST(Preview, AMeshIsBrightBeforeADarkBackdrop) {
  const Preview preview = previewMesh(square(), {.size_px = 33, .yaw_deg = 0, .pitch_deg = 0}, "square.ply");
  EXPECT_EQ(preview.image.width, 33);
  const float center = preview.image.texel(16, 16)[0], corner = preview.image.texel(0, 0)[0];
  EXPECT_GT(center, 0.5f);
  EXPECT_LT(corner, 0.3f);
}

TEST(Preview, MissingNormalsAreMadeAndEqualTheTrueOnes) {
  TriangleMesh with_normals = square();
  with_normals.normals.assign(4, {0, 0, 1});
  const Preview made = previewMesh(square(), {.size_px = 16}, "a"),
                given = previewMesh(with_normals, {.size_px = 16}, "a");
  EXPECT_EQ(made.image.values, given.image.values);
  EXPECT_NE(made.caption, given.caption);
}

TEST(Preview, AMeshWithoutExtentIsAnError) {
  EXPECT_THROW(previewMesh({}, {}, "empty.ply"), Error);
}

TEST(Preview, APackShowsItsBaseColor) {
  const formats::Pack pack = squarePack();
  const Preview preview = previewPack(pack, {.size_px = 17, .yaw_deg = 0, .pitch_deg = 0}, "a.glb");
  const auto center = pixel(preview.image, 8, 8);
  EXPECT_GT(center[0], 0.6f);
  EXPECT_EQ(center[1], 0);
  EXPECT_EQ(center[2], 0);
}

TEST(Preview, APackShowsItsLobe) {
  formats::Pack pack = squarePack();
  formats::ShTransfer& transfer = pack.sh();
  makeGlossy(transfer, formats::Storage::kMatrix, 1);
  transfer.glossy->tangents.assign(4, {1, 0, 0, 1});
  transfer.glossy->vertexTable() = tableOf(4, 1);  // order 1: transferred radiance is the mean of the light
  reflectionOf(pack) = formats::PhongLobe{0, {0, 1, 0}};
  const PreviewOptions options = {.size_px = 17, .yaw_deg = 0, .pitch_deg = 0};
  const auto glossy = pixel(previewPack(pack, options, "a.glb").image, 8, 8);
  // The lobe returns all of that mean, as a green albedo does.
  formats::Pack yellow = squarePack();
  yellow.appearances[0].base_color = {1, 1, 0};
  const auto diffuse = pixel(previewPack(yellow, options, "a.glb").image, 8, 8);
  EXPECT_GT(diffuse[1], 0.5f);
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(glossy[c], diffuse[c], 1e-4f);
}

TEST(Preview, AnHdrImageHasItsMeanAtTheMiddleValue) {
  Image image(4, 2, {"R", "G", "B"});
  for (float& v : image.values) v = 100;
  const Preview preview = previewImage(image, false, {.size_px = 16});
  EXPECT_EQ(preview.image.width, 16);
  EXPECT_EQ(preview.image.height, 8);
  for (const float v : preview.image.values) EXPECT_FLOAT_EQ(v, transport::srgbFromLinear(0.4f));
  EXPECT_THAT(preview.caption, HasSubstr("-7.97 EV"));  // log2(0.4 / 100)
}

TEST(Preview, ADisplayEncodedImageIsShownAsItStands) {
  Image image(2, 1, {"R", "G", "B"});
  image.values = {0, 0.25f, 0.5f, 1, 0.75f, 0.5f};
  const Preview preview = previewImage(image, true, {.size_px = 4});
  EXPECT_THAT(pixel(preview.image, 1, 0), ElementsAre(0, 0.25f, 0.5f));
  EXPECT_THAT(pixel(preview.image, 2, 1), ElementsAre(1, 0.75f, 0.5f));
}

TEST(Preview, ShrinkingAveragesAndNanIsMagenta) {
  Image image(4, 1, {"R", "G", "B"});
  for (std::size_t i = 0; i < 6; ++i) image.values[i] = i < 3 ? 0.0f : 1.0f;
  image.values[9] = std::nanf("");
  const Preview preview = previewImage(image, true, {.size_px = 2});
  EXPECT_THAT(pixel(preview.image, 0, 0), ElementsAre(0.5f, 0.5f, 0.5f));
  EXPECT_THAT(pixel(preview.image, 1, 0), ElementsAre(1, 0, 1));
}

TEST(Preview, OtherChannelsAreScaledToGray) {
  Image image(2, 1, {"depth", "id"});
  image.values = {-5, 7, 15, 7};
  const Preview preview = previewImage(image, false, {.size_px = 2});
  EXPECT_THAT(pixel(preview.image, 0, 0), ElementsAre(0, 0, 0));
  EXPECT_THAT(pixel(preview.image, 1, 0), ElementsAre(1, 1, 1));
  EXPECT_THAT(preview.caption, HasSubstr("channel depth: black is -5, white is 15"));
}

TEST(Preview, AHeatMapHasBlueBelowWhiteAtAndRedAboveZero) {
  const Preview preview = previewTensors(table({-2, 0, 2}, 1, 3), {.size_px = 30}, "a");
  const auto low = pixel(preview.image, 5, 5), high = pixel(preview.image, 25, 5);
  EXPECT_THAT(pixel(preview.image, 15, 5), ElementsAre(1, 1, 1));
  EXPECT_THAT(low, ElementsAre(FloatNear(0.230f, 1e-6f), FloatNear(0.299f, 1e-6f), FloatNear(0.754f, 1e-6f)));
  EXPECT_THAT(high,
              ElementsAre(FloatNear(0.706f, 1e-6f), FloatNear(0.016f, 1e-6f), FloatNear(0.150f, 1e-6f)));
  EXPECT_THAT(preview.caption, HasSubstr("blue is -2, white is 0, red is 2"));
}

TEST(Preview, BandsAreDivided) {
  const Preview preview = previewTensors(table({0, 0, 0, 0}, 1, 4), {.size_px = 16}, "a");
  EXPECT_THAT(pixel(preview.image, 4, 0), ElementsAre(0.25f, 0.25f, 0.25f));  // between l = 0 and l = 1
  EXPECT_THAT(pixel(preview.image, 8, 0), ElementsAre(1, 1, 1));
}

TEST(Preview, ColoredTransferHasItsChannelsSideBySide) {
  formats::TensorFile file = table(std::vector<float>(12, 0.0f), 1, 12);
  file.tensors["transfer"].shape = {1, 3, 4};
  const Preview preview = previewTensors(file, {.size_px = 48}, "a");
  EXPECT_THAT(pixel(preview.image, 20, 0), ElementsAre(0.25f, 0.25f, 0.25f));  // green, between l = 0 and 1
  EXPECT_THAT(pixel(preview.image, 24, 0), ElementsAre(1, 1, 1));
}

TEST(Preview, TensorsWithoutATableAreAnError) {
  formats::TensorFile file;
  file.tensors["list"] = Tensor::from<float>(ElementType::kFloat32, {3}, std::vector<float>{1, 2, 3});
  EXPECT_THROW(previewTensors(file, {}, "a"), Error);
}

}  // namespace
}  // namespace bakelight::inspect
