// Images of integers, and images by blocks of rows.
#include "formats/index_image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/error.h"
#include "formats/exr_rows.h"
#include "formats/file.h"
#include "formats/image.h"
#include "tests/support/temporary_folder.h"

namespace bakelight::formats {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

template <class Read>
std::string problemOf(const Read& read) {
  try {
    read();
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    return error.what();
  }
  return "no error";
}

class IndexImageTest : public testing::Test {
 protected:
  IndexImageTest() {
    for (std::size_t i = 0; i < image_.values.size(); ++i)
      image_.values[i] = static_cast<std::uint32_t>(3 * i);
    image_.values[5] = 0xffffffffU;  // no float holds it
    writeIndexExr(file_, image_, {{"bakelight:note", "here"}});
  }

  tests::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "ids.exr";
  IndexImage image_{37, 21, {"vertex", "material"}};
};

TEST_F(IndexImageTest, KeepsEveryBit) {
  const IndexImage read = readIndexExr(file_, {"vertex", "material"});
  EXPECT_EQ(read.width, 37);
  EXPECT_EQ(read.height, 21);
  EXPECT_EQ(read.values, image_.values);
  const IndexImage one = readIndexExr(file_, {"material"});
  EXPECT_EQ(one.texel(3, 4)[0], image_.texel(3, 4)[1]);
  EXPECT_EQ(readImageMetadata(file_).at("bakelight:note"), "here");
  EXPECT_THAT(exrChannels(file_), ElementsAre("material", "vertex"));
}

TEST_F(IndexImageTest, OpensAsAnImage) {
  const Image seen = readImage(file_);
  ASSERT_GE(seen.channelIndex("vertex"), 0);
  EXPECT_EQ(seen.texel(7, 9)[seen.channelIndex("vertex")], static_cast<float>(image_.texel(7, 9)[0]));
}

TEST_F(IndexImageTest, WhatIsNoImageOfIntegersIsRefused) {
  EXPECT_THAT(problemOf([&] { readIndexExr(file_, {"patch.U"}); }), HasSubstr("channel patch.U"));
  const auto floats = folder_.path() / "floats.exr";
  writeExr(floats, Image(2, 2, {"vertex"}));
  EXPECT_THAT(problemOf([&] { readIndexExr(floats, {"vertex"}); }), HasSubstr("no integers"));
  EXPECT_THAT(problemOf([&] { readIndexExr(folder_.path() / "none.exr", {"vertex"}); }),
              HasSubstr("no such file"));
  const auto text = folder_.path() / "text.exr";
  writeFileAtomically(text, std::string_view("no picture"));
  EXPECT_THAT(problemOf([&] { readIndexExr(text, {"vertex"}); }), HasSubstr("no OpenEXR file"));
  EXPECT_TRUE(exrChannels(text).empty());
  Bytes bytes = readFile(file_);
  bytes.resize(bytes.size() - 200);
  const auto cut = folder_.path() / "cut.exr";
  writeFileAtomically(cut, bytes);
  EXPECT_THAT(problemOf([&] { readIndexExr(cut, {"vertex"}); }), HasSubstr("cut.exr"));
}

TEST(ExrRows, AreThoseOfTheWholeImage) {
  const tests::TemporaryFolder folder;
  const auto file = folder.path() / "rows.exr";
  Image image(23, 50, {"a", "b", "c"});
  for (std::size_t i = 0; i < image.values.size(); ++i) image.values[i] = static_cast<float>(i) / 7;
  writeExr(file, image, ExrPrecision::kFloat);
  ExrRows rows(file, {"c", "a"});
  EXPECT_EQ(rows.width(), 23);
  EXPECT_EQ(rows.height(), 50);
  for (const auto& [first, count] :
       {std::pair(0, 50), std::pair(49, 1), std::pair(13, 20), std::pair(0, 1)}) {
    std::vector<float> values(static_cast<std::size_t>(2 * 23 * count));
    rows.read(first, count, values);
    for (int y = 0; y < count; ++y)
      for (int x = 0; x < 23; ++x) {
        EXPECT_EQ(values[static_cast<std::size_t>(2 * (y * 23 + x))], image.texel(x, first + y)[2]);
        EXPECT_EQ(values[static_cast<std::size_t>(2 * (y * 23 + x) + 1)], image.texel(x, first + y)[0]);
      }
  }
  std::vector<float> values(2 * 23);
  EXPECT_THROW(rows.read(50, 1, values), std::logic_error);
  EXPECT_THAT(problemOf([&] { ExrRows(file, {"d"}); }), HasSubstr("channel d"));
}

}  // namespace
}  // namespace bakelight::formats
