#include "formats/color_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <span>

#include "formats/error.h"
#include "formats/file.h"
#include "tests/support/temporary_folder.h"

namespace bakelight::formats {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
const std::filesystem::path kCases = std::filesystem::path(BAKELIGHT_SOURCE_DIR) / "tests/cases/hdr";

ColorPicture read(const std::filesystem::path& path, PictureUse use = PictureUse::kLight) {
  return readColorPicture(path, use);
}

std::string errorOf(const std::filesystem::path& path) {
  try {
    read(path);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

// A part of an OpenEXR file: channels with one value each, everywhere.
struct Part {
  std::vector<std::string> channels;
  std::vector<float> values;
};

void writeParts(const std::filesystem::path& path, const std::vector<Part>& parts) {
  constexpr int kWidth = 4, kHeight = 2;
  std::vector<OIIO::ImageSpec> specs;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    OIIO::ImageSpec spec(kWidth, kHeight, static_cast<int>(parts[i].channels.size()), OIIO::TypeDesc::FLOAT);
    spec.channelnames = parts[i].channels;
    spec.attribute("oiio:subimagename", "part" + std::to_string(i));
    specs.push_back(spec);
  }
  auto output = OIIO::ImageOutput::create("exr");
  ASSERT_TRUE(output->open(path.string(), static_cast<int>(specs.size()), specs.data()));
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i > 0) {
      ASSERT_TRUE(output->open(path.string(), specs[i], OIIO::ImageOutput::AppendSubimage));
    }
    std::vector<float> texels;
    for (int texel = 0; texel < kWidth * kHeight; ++texel)
      texels.insert(texels.end(), parts[i].values.begin(), parts[i].values.end());
    ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, texels.data()));
  }
  ASSERT_TRUE(output->close());
}

std::vector<float> firstTexel(const ColorPicture& picture) {
  return {picture.image.values.begin(), picture.image.values.begin() + 3};
}

// A Radiance picture 4 × 2 whose red is 1 + x + 4 y, x to the right and y down, stored as its resolution line
// says.
void writeRadiance(const std::filesystem::path& path, const std::string& major, const std::string& minor) {
  const auto size = [](const std::string& axis) { return axis[1] == 'X' ? 4 : 2; };
  const auto along = [&](const std::string& axis, int i) {  // +X runs to the right, -Y down
    return axis == "+X" || axis == "-Y" ? i : size(axis) - 1 - i;
  };
  std::string text = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + major + " " + std::to_string(size(major)) +
                     " " + minor + " " + std::to_string(size(minor)) + "\n";
  for (int i = 0; i < size(major); ++i)
    for (int j = 0; j < size(minor); ++j) {
      const int a = along(major, i), b = along(minor, j);
      const int x = major[1] == 'X' ? a : b, y = major[1] == 'X' ? b : a;
      text += static_cast<char>(8 * (1 + x + 4 * y));  // ÷ 256 · 2⁵
      text += std::string("\0\0", 2) + static_cast<char>(128 + 5);
    }
  writeFileAtomically(path, text);
}

TEST(ColorPicture, RadiancePicturesLieAsTheirResolutionLineSays) {
  const tests::TemporaryFolder folder;
  for (const std::string first : {"-", "+"})
    for (const std::string second : {"-", "+"})
      for (const bool columns : {false, true}) {
        const std::string major = first + (columns ? "X" : "Y"), minor = second + (columns ? "Y" : "X");
        writeRadiance(folder / "a.hdr", major, minor);
        const ColorPicture picture = read(folder / "a.hdr");
        ASSERT_EQ(picture.image.width, 4) << major << minor;
        ASSERT_EQ(picture.image.height, 2) << major << minor;
        for (int y = 0; y < 2; ++y)
          for (int x = 0; x < 4; ++x)
            EXPECT_EQ(picture.image.texel(x, y)[0], 1 + x + 4 * y)
                << major << " " << minor << ": " << x << ", " << y;
        EXPECT_EQ(readImage(folder / "a.hdr").texel(3, 0)[0], 4) << major << minor;
      }
}

TEST(ColorPicture, RowsFromTheBottomGiveTheSameLight) {
  const Image upright = read(kCases / "plus_y_plus_x.hdr").image;
  double above = 0, below = 0;
  for (int y = 0; y < upright.height; ++y)
    for (int x = 0; x < upright.width; ++x)
      (y < upright.height / 2 ? above : below) += upright.texel(x, y)[2];
  EXPECT_GT(above, below) << "the sky is above";
}

TEST(ColorPicture, OtherFormatsLieAsExifSays) {
  const tests::TemporaryFolder folder;
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const bool transposed = orientation > 4;
    OIIO::ImageSpec spec(transposed ? 2 : 4, transposed ? 4 : 2, 3, OIIO::TypeDesc::FLOAT);
    spec.attribute("Orientation", orientation);
    std::vector<float> stored;
    for (int row = 0; row < spec.height; ++row)
      for (int column = 0; column < spec.width; ++column) {
        // Where Exif 2.3 says that row 0 and column 0 lie.
        const bool bottom = orientation == 3 || orientation == 4 || orientation == 7 || orientation == 8;
        const bool right = orientation == 2 || orientation == 3 || orientation == 6 || orientation == 7;
        const int along_x = transposed ? row : column, along_y = transposed ? column : row;
        const int x = right ? 3 - along_x : along_x, y = bottom ? 1 - along_y : along_y;
        stored.insert(stored.end(), {static_cast<float>(1 + x + 4 * y), 0, 0});
      }
    auto output = OIIO::ImageOutput::create("tiff");
    ASSERT_TRUE(output->open((folder / "a.tif").string(), spec));
    ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, stored.data()));
    ASSERT_TRUE(output->close());
    const Image image = read(folder / "a.tif").image;
    ASSERT_EQ(image.width, 4) << orientation;
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 4; ++x) EXPECT_EQ(image.texel(x, y)[0], 1 + x + 4 * y) << orientation;
  }
}

// Stored 4 × 2, lying as Exif's `orientation` says; red grows to the right, green downwards.
void writePicture(const std::filesystem::path& path, int orientation) {
  OIIO::ImageSpec spec(4, 2, 3, OIIO::TypeDesc::UINT8);
  spec.attribute("Orientation", orientation);
  spec.attribute("CompressionQuality", 100);
  std::vector<std::uint8_t> codes;
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x)
      codes.insert(codes.end(),
                   {static_cast<std::uint8_t>(40 + 50 * x), static_cast<std::uint8_t>(60 + 90 * y), 100});
  auto output = OIIO::ImageOutput::create(path.string());
  ASSERT_TRUE(output && output->open(path.string(), spec)) << path;
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::UINT8, codes.data()));
  ASSERT_TRUE(output->close());
}

TEST(ColorPicture, PicturesInMemoryAreTheSameWhateverTheirKind) {
  const tests::TemporaryFolder folder;
  for (const char* name : {"a.png", "a.jpg", "a.bmp", "a.tga", "a.tif", "a.webp"}) {
    const auto path = folder / name;
    writePicture(path, 1);
    const Image file = readColorPicture(path, PictureUse::kReflectance).image;
    const Image bytes = readColorPicture(readFile(path), "skin", PictureUse::kReflectance).image;
    ASSERT_EQ(bytes.width, 4) << name;
    ASSERT_EQ(bytes.height, 2) << name;
    EXPECT_EQ(bytes.values, file.values) << name;
    EXPECT_GT(bytes.texel(3, 0)[0], 2 * bytes.texel(1, 0)[0]) << name;
    EXPECT_GT(bytes.texel(0, 1)[1], 2 * bytes.texel(0, 0)[1]) << name << ": the first row is on top";
  }
  for (const std::string text : {"no picture at all, but a text", "\x89PNG and no more", "BM", ""}) {
    const auto bytes = std::as_bytes(std::span(text));
    try {
      readColorPicture(bytes, "skin", PictureUse::kReflectance);
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("skin")) << text;
    }
  }
}

TEST(ColorPicture, AsStoredExifDoesNotCount) {
  const tests::TemporaryFolder folder;
  writePicture(folder / "a.jpg", 6);
  const auto bytes = readFile(folder / "a.jpg");
  for (const auto& [turn, width] : {std::pair{PictureTurn::kAsFileSays, 2}, {PictureTurn::kAsStored, 4}}) {
    EXPECT_EQ(readColorPicture(folder / "a.jpg", PictureUse::kReflectance, turn).image.width, width);
    EXPECT_EQ(readColorPicture(bytes, "skin", PictureUse::kReflectance, turn).image.width, width);
  }
  const Image stored =
      readColorPicture(bytes, "skin", PictureUse::kReflectance, PictureTurn::kAsStored).image;
  EXPECT_GT(stored.texel(3, 0)[0], 2 * stored.texel(1, 0)[0]);
  const Image turned = readColorPicture(bytes, "skin", PictureUse::kReflectance).image;
  EXPECT_GT(turned.texel(1, 3)[0], 2 * turned.texel(1, 1)[0]) << "6: the first column is on top";
}

TEST(ColorPicture, EightBitLightIsDecodedWithANote) {
  const ColorPicture picture = read(kCases / "sky_8_bit.png");
  const Image codes = readImage(kCases / "sky_8_bit.png");
  for (std::size_t i = 0; i < codes.values.size(); ++i) {
    const double srgb = codes.values[i];
    const double linear = srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
    ASSERT_NEAR(picture.image.values[i], linear, 1e-6);
  }
  ASSERT_EQ(picture.notes.size(), 1U);
  EXPECT_THAT(picture.notes[0], HasSubstr("8-bit"));
  EXPECT_THAT(read(kCases / "sky_8_bit.png", PictureUse::kReflectance).notes, IsEmpty());
}

TEST(ColorPicture, IntegersOfEveryWidthAndCountOfChannels) {
  const tests::TemporaryFolder folder;
  for (const auto type : {OIIO::TypeDesc::UINT8, OIIO::TypeDesc::UINT16})
    for (const int channels : {1, 2, 3, 4})
      for (const std::string ending : {"png", "tif"}) {
        const std::filesystem::path file = folder / ("a." + ending);
        OIIO::ImageSpec spec(4, 2, channels, type);
        spec["oiio:UnassociatedAlpha"] = 1;  // written as they stand here
        const std::vector<float> half(static_cast<std::size_t>(8 * channels), 0.5F);
        auto output = OIIO::ImageOutput::create(ending);
        ASSERT_TRUE(output->open(file.string(), spec));
        ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, half.data()));
        ASSERT_TRUE(output->close());
        for (const float value : firstTexel(read(file)))
          EXPECT_NEAR(value, 0.2140, 0.002) << ending << ", " << channels << " channels";
      }
}

TEST(ColorPicture, FloatsAreLinearAsTheyAre) {
  const tests::TemporaryFolder folder;
  writeParts(folder / "a.exr", {{{"R", "G", "B"}, {0.5F, 7, 0}}});
  const ColorPicture picture = read(folder / "a.exr");
  EXPECT_EQ(firstTexel(picture), (std::vector<float>{0.5F, 7, 0}));
  EXPECT_FALSE(picture.decoded);
  EXPECT_THAT(picture.notes, IsEmpty());
}

TEST(ColorPicture, OnlyTheChannelsThatAreUsedHaveToBeFinite) {
  const tests::TemporaryFolder folder;
  writeParts(folder / "a.exr", {{{"R", "G", "B", "Z"}, {1, 2, 3, kInfinity}}});
  EXPECT_EQ(firstTexel(read(folder / "a.exr")), (std::vector<float>{1, 2, 3}));
  writeParts(folder / "a.exr", {{{"R", "G", "B", "Z"}, {1, kInfinity, 3, 4}}});
  EXPECT_THAT(errorOf(folder / "a.exr"), HasSubstr("texel (0, 0), channel G"));
}

TEST(ColorPicture, TheColorIsFoundInWhicheverPartOrLayerItIs) {
  const tests::TemporaryFolder folder;
  const std::vector<float> expected = {1, 2, 3};
  const std::vector<std::vector<Part>> right = {
      {{{"Z"}, {9}}, {{"R", "G", "B"}, {1, 2, 3}}},
      {{{"Z", "A"}, {9, 1}}, {{"beauty.R", "beauty.G", "beauty.B"}, {1, 2, 3}}},
      {{{"View.Combined.R", "View.Combined.G", "View.Combined.B", "View.Normal.X"}, {1, 2, 3, 9}}},
      {{{"albedo.R", "albedo.G", "albedo.B", "beauty.R", "beauty.G", "beauty.B"}, {7, 8, 9, 1, 2, 3}}},
      {{{"albedo.R", "albedo.G", "albedo.B", "R", "G", "B"}, {7, 8, 9, 1, 2, 3}}},
      {{{"red", "green", "blue"}, {1, 2, 3}}}};
  for (const std::vector<Part>& parts : right) {
    writeParts(folder / "a.exr", parts);
    EXPECT_EQ(firstTexel(read(folder / "a.exr")), expected) << parts.front().channels.front();
  }
  writeParts(folder / "a.exr", {{{"Y"}, {5}}});
  EXPECT_EQ(firstTexel(read(folder / "a.exr")), (std::vector<float>{5, 5, 5}));
}

TEST(ColorPicture, WhatIsNoColorIsRefusedByName) {
  const tests::TemporaryFolder folder;
  const std::vector<std::pair<std::vector<Part>, std::string>> wrong = {
      {{{{"Z"}, {1}}}, "Z"},
      {{{{"Z"}, {1}}, {{"N.X", "N.P", "N.Q"}, {1, 2, 3}}}, "N.X"},
      {{{{"BY", "RY", "Y"}, {1, 2, 3}}}, "RY"},
      {{{{"R", "G"}, {1, 2}}}, "R, G"},
      {{{{"a.R", "a.G", "a.B", "b.R", "b.G", "b.B"}, {1, 2, 3, 4, 5, 6}}}, "a, b"}};
  for (const auto& [parts, word] : wrong) {
    writeParts(folder / "a.exr", parts);
    EXPECT_THAT(errorOf(folder / "a.exr"), HasSubstr(word));
    EXPECT_THAT(errorOf(folder / "a.exr"), HasSubstr("a.exr"));
  }
}

TEST(ColorPicture, BlackLightIsTold) {
  const tests::TemporaryFolder folder;
  writeParts(folder / "a.exr", {{{"R", "G", "B"}, {0, 0, 0}}});
  EXPECT_THAT(read(folder / "a.exr").notes, testing::ElementsAre(HasSubstr("black")));
}

}  // namespace
}  // namespace bakelight::formats
