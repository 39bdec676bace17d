#include "formats/image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "formats/error.h"
#include "formats/file.h"
#include "tests/unit/formats/test_meshes.h"

namespace bakelight::formats {
namespace {

using testing::HasSubstr;

std::string errorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

Image gradient(int width, int height, std::vector<std::string> channels) {
  Image image(width, height, std::move(channels));
  for (std::size_t i = 0; i < image.values.size(); ++i) image.values[i] = static_cast<float>(i) / 3 - 5;
  return image;
}

TEST(Image, FloatExrIsExactByChannelName) {
  const ScratchFolder folder;
  const Image image = gradient(7, 5, {"sh01.R", "sh00.R", "id"});
  writeExr(folder / "a.exr", image, ExrPrecision::kFloat, {{"bakelight:unit", "sr"}});
  const Image read = readImage(folder / "a.exr");
  ASSERT_EQ(read.width, 7);
  ASSERT_EQ(read.height, 5);
  ASSERT_EQ(read.channelCount(), 3U);
  for (const std::string& name : image.channel_names) {
    const int from = image.channelIndex(name), to = read.channelIndex(name);
    ASSERT_GE(to, 0) << name;
    for (int y = 0; y < 5; ++y) {
      for (int x = 0; x < 7; ++x) EXPECT_EQ(read.texel(x, y)[to], image.texel(x, y)[from]);
    }
  }
  EXPECT_EQ(read.channelIndex("none"), -1);
}

TEST(Image, HalfExrIsExactForWhatHalfHolds) {
  const ScratchFolder folder;
  Image image(4, 1, {"Y"});
  image.values = {2048, -65504, 0x1p-24F, 1 + 0x1p-10F};
  writeExr(folder / "a.exr", image);
  EXPECT_EQ(readImage(folder / "a.exr").values, image.values);
}

TEST(Image, WhatDoesNotFitHalfIsNamedAndNothingIsWritten) {
  const ScratchFolder folder;
  Image image = gradient(4, 3, {"R", "G"});
  image.texel(2, 1)[1] = 65505;
  EXPECT_THAT(errorOf([&] { writeExr(folder / "a.exr", image); }),
              testing::AllOf(HasSubstr("texel (2, 1)"), HasSubstr("channel G")));
  EXPECT_EQ(folder.fileCount(), 0U);
  writeExr(folder / "a.exr", image, ExrPrecision::kFloat);
  image.texel(0, 2)[0] = std::nanf("");
  EXPECT_THAT(errorOf([&] { writeExr(folder / "b.exr", image, ExrPrecision::kFloat); }), HasSubstr("NaN"));
  EXPECT_EQ(folder.fileCount(), 1U);
}

TEST(Image, OutputsCarryNoDateHostOrProgram) {
  const ScratchFolder folder;
  const Image image = gradient(3, 3, {"R", "G", "B"});
  writeExr(folder / "a.exr", image);
  writePng(folder / "a.png", image);
  for (const char* name : {"a.exr", "a.png"}) {
    const std::string text = readTextFile(folder / name);
    for (const char* word :
         {"capDate", "DateTime", "Software", "OpenImageIO", "hostName", "HostComputer", "tIME", "Date"}) {
      EXPECT_EQ(text.find(word), std::string::npos) << name << " says " << word;
    }
  }
}

TEST(Image, MetadataComeBack) {
  const ScratchFolder folder;
  const std::map<std::string, std::string> metadata = {{"bakelight:eye", "0.1 -2.5e-3 3"},
                                                       {"bakelight:frame", "{\"width\": 640, \"π\": \"\"}"}};
  writeExr(folder / "a.exr", gradient(3, 2, {"R", "G", "B"}), ExrPrecision::kFloat, metadata);
  const auto read = readImageMetadata(folder / "a.exr");
  for (const auto& [key, value] : metadata) {
    ASSERT_TRUE(read.contains(key)) << key;
    EXPECT_EQ(read.at(key), value);
  }
  writeExr(folder / "b.exr", gradient(3, 2, {"R"}));
  for (const auto& [key, value] : readImageMetadata(folder / "b.exr"))
    EXPECT_FALSE(key.starts_with("bakelight:")) << key;
  EXPECT_THAT(errorOf([&] { readImageMetadata(folder / "none.exr"); }), HasSubstr("none.exr"));
}

TEST(Image, DataUriCarriesThePng) {
  const ScratchFolder folder;
  Image image(3, 2, {"R", "G", "B", "A"});
  for (std::size_t i = 0; i < image.values.size(); ++i) image.values[i] = static_cast<float>(i) / 23;
  const std::string uri = pngDataUri(image), begin = "data:image/png;base64,";
  ASSERT_TRUE(uri.starts_with(begin));
  std::string decoded;
  unsigned bits = 0;
  int count = 0;
  for (const char c : uri.substr(begin.size(), uri.find('=') - begin.size())) {
    const std::size_t value =
        std::string("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/").find(c);
    ASSERT_NE(value, std::string::npos);
    bits = bits << 6 | static_cast<unsigned>(value);
    count += 6;
    if (count >= 8) decoded += static_cast<char>(bits >> (count -= 8));
  }
  writePng(folder / "a.png", image);
  EXPECT_EQ(decoded, readTextFile(folder / "a.png"));
}

TEST(Image, PngRoundsAndClamps) {
  const ScratchFolder folder;
  Image image(4, 1, {"Y"});
  image.values = {-1, 100.4F / 255, 100.6F / 255, 2};
  writePng(folder / "a.png", image);
  const Image read = readImage(folder / "a.png");
  ASSERT_EQ(read.values.size(), 4U);
  const float codes[] = {0, 100, 101, 255};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_FLOAT_EQ(read.values[i], codes[i] / 255);
}

TEST(Image, AlphaDoesNotTouchColor) {
  const ScratchFolder folder;
  Image image(1, 1, {"R", "G", "B", "A"});
  image.values = {1, 0.2F, 0.4F, 0};
  writePng(folder / "a.png", image);
  const Image read = readImage(folder / "a.png");
  EXPECT_FLOAT_EQ(read.values[0], 1);
  EXPECT_FLOAT_EQ(read.values[3], 0);
}

TEST(Image, MissingCutAndForeignFilesAreNamed) {
  const ScratchFolder folder;
  EXPECT_THAT(errorOf([&] { readImage(folder / "none.exr"); }), HasSubstr("none.exr"));
  const Image image = gradient(40, 40, {"R", "G", "B"});
  for (const char* name : {"a.exr", "a.png"}) {
    if (std::string(name) == "a.exr") writeExr(folder / name, image);
    if (std::string(name) == "a.png") writePng(folder / name, image);
    const std::string whole = readTextFile(folder / name);
    for (const double share : {0.0, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9}) {
      writeFileAtomically(
          folder / name,
          whole.substr(0, static_cast<std::size_t>(static_cast<double>(whole.size()) * share)));
      EXPECT_THAT(errorOf([&] { readImage(folder / name); }), HasSubstr(name)) << share;
    }
  }
  writeFileAtomically(folder / "b.exr", std::string_view("not an image"));
  EXPECT_THAT(errorOf([&] { readImage(folder / "b.exr"); }), HasSubstr("b.exr"));
}

}  // namespace
}  // namespace bakelight::formats
