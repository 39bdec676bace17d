#include "formats/radiance_transfer_texture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "formats/compare.h"
#include "formats/error.h"
#include "tests/support/temporary_folder.h"

namespace bakelight::formats {
namespace {

using testing::HasSubstr;

RadianceTransferTexture texture(const std::string& material, int views, int width, int height) {
  RadianceTransferTexture texture{
      .material = material, .order = 3, .views = views, .width = width, .height = height};
  texture.allocate();
  for (std::size_t i = 0; i < texture.values.size(); ++i) texture.values[i] = static_cast<float>(i) / 64;
  return texture;
}

std::string problemOf(const std::filesystem::path& file) {
  try {
    readRadianceTransferTextures(file);
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    return error.what();
  }
  return "no error";
}

class RadianceTransferTextureTest : public testing::Test {
 protected:
  tests::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "rtt.exr";
};

TEST_F(RadianceTransferTextureTest, SeveralComeBackBitForBit) {
  std::vector<RadianceTransferTexture> written = {texture("", 4, 5, 3), texture("mail", 1, 16, 8)};
  for (std::size_t i = 0; i < written[0].responseCount(); ++i)
    written[0].heights.push_back(static_cast<float>(i) / 8 - 3);
  writeRadianceTransferTextures(file_, written, ExrPrecision::kFloat);
  EXPECT_TRUE(isRadianceTransferTexture(file_));
  const auto read = readRadianceTransferTextures(file_);
  ASSERT_EQ(read.size(), 2U);
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].material, written[i].material);
    EXPECT_EQ(read[i].order, 3);
    EXPECT_EQ(read[i].views, written[i].views);
    EXPECT_EQ(read[i].width, written[i].width);
    EXPECT_EQ(read[i].height, written[i].height);
    EXPECT_EQ(read[i].values, written[i].values);
    EXPECT_EQ(read[i].heights, written[i].heights);
  }
}

// What a person sees: the view from +x, +y is the picture at the upper right.
TEST_F(RadianceTransferTextureTest, ViewsLieAsSeenFromAbove) {
  RadianceTransferTexture written = texture("", 2, 2, 2);
  std::fill(written.values.begin(), written.values.end(), 0.0F);
  written.response(1, 1, 0, 0)[9 + 2] = 0.5F;  // green of coefficient 2
  writeRadianceTransferTextures(file_, std::span(&written, 1), ExrPrecision::kFloat);
  const Image image = readImage(file_);
  ASSERT_EQ(image.width, 4);
  ASSERT_EQ(image.height, 4);
  const int channel = image.channelIndex("sh02.G");
  ASSERT_GE(channel, 0);
  EXPECT_EQ(image.texel(2, 0)[channel], 0.5F);
}

TEST_F(RadianceTransferTextureTest, WhatDoesNotFitIsRefused) {
  writeExr(file_, Image(2, 2, {"R", "G", "B"}));
  EXPECT_FALSE(isRadianceTransferTexture(file_));
  EXPECT_THAT(problemOf(file_), HasSubstr("radiance transfer textures"));

  const std::string key = "bakelight:radiance_transfer_textures";
  Image image(2, 2, {"sh00.R", "sh00.G", "sh00.B"});
  const auto write = [&](const std::string& layout) {
    writeExr(file_, image, ExrPrecision::kHalf, {{key, layout}});
  };
  write(R"({"order":1,"textures":[{"material":"","views":2,"width":1,"height":1}]})");
  EXPECT_EQ(problemOf(file_), "no error");
  write(R"({"order":1,"textures":[{"material":"","views":2,"width":2,"height":1}]})");
  EXPECT_THAT(problemOf(file_), HasSubstr("4 × 2"));
  write(R"({"order":2,"textures":[{"material":"","views":2,"width":1,"height":1}]})");
  EXPECT_THAT(problemOf(file_), HasSubstr("sh01.R"));
  write(R"({"order":1,"textures":[{"material":"","views":0,"width":1,"height":1}]})");
  EXPECT_THAT(problemOf(file_), HasSubstr("/textures/0/views"));
  write(R"({"order":1,"textures":[{"material":"","views":2,"width":1,"height":1,"heights":true}]})");
  EXPECT_THAT(problemOf(file_), HasSubstr("channel height"));
  write(R"({"order":1,"textures":[]})");
  EXPECT_THAT(problemOf(file_), HasSubstr("names no texture"));
  write("{");
  EXPECT_NE(problemOf(file_), "no error");
}

TEST(RadianceTransferTexture, IsCompared) {
  RadianceTransferTexture one{.material = "lid", .order = 2, .views = 1, .width = 2, .height = 2};
  one.allocate();
  std::fill(one.values.begin(), one.values.end(), 1.0F);
  RadianceTransferTexture other = one;
  const CompareLimits limits{.maximum = 0.1, .relative = 0.01};
  EXPECT_TRUE(compareRadianceTransferTextures({&one, 1}, {&other, 1}, limits).passes());
  other.values[3] = 1.2F;
  EXPECT_FALSE(compareRadianceTransferTextures({&one, 1}, {&other, 1}, limits).passes());
  other = one;
  one.heights = other.heights = {0, 1, 2, 3};
  EXPECT_TRUE(compareRadianceTransferTextures({&one, 1}, {&other, 1}, limits).passes());
  other.heights[2] = 2.2F;
  EXPECT_FALSE(compareRadianceTransferTextures({&one, 1}, {&other, 1}, limits).passes());
  other = one;
  other.material = "";
  EXPECT_EQ(compareRadianceTransferTextures({&one, 1}, {&other, 1}, limits).mismatches.size(), 1U);
}

}  // namespace
}  // namespace bakelight::formats
