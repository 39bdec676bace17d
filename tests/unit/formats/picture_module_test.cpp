// Ordinary OpenEXR files are read without the module of readers; everything else loads it.
#include "formats/picture_module.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/exr_image.h"
#include "formats/file.h"
#include "formats/gltf_uri.h"
#include "formats/module.h"
#include "tests/support/temporary_folder.h"

namespace bakelight::formats {
namespace {

using testing::HasSubstr;

Image numbered(std::vector<std::string> channels) {
  Image image(5, 3, std::move(channels));
  for (std::size_t i = 0; i < image.values.size(); ++i) image.values[i] = 0.25F * static_cast<float>(i) - 2;
  return image;
}

TEST(PlainExr, IsWhatTheReadersOfAllKindsRead) {
  const tests::TemporaryFolder folder;
  const std::vector<std::vector<std::string>> channel_lists = {
      {"R", "G", "B"},
      {"A", "B", "G", "R"},
      {"Y"},
      {"Z", "R", "A", "G", "B", "N.X", "N.Y", "N.Z"},
      {"diffuse.B", "diffuse.R", "diffuse.G", "B", "G", "R", "albedo.red", "albedo.blue", "albedo.green"},
      {"position.x", "position.y", "position.z", "chart", "area", "normal.z", "normal.x", "normal.y"},
      {"X", "Y", "Z", "B", "G", "R"},
      {"N.X", "N.Z", "M.Y", "M.Z", "M.depth"},
      {"variance.R", "variance.B", "variance.G", "R", "G", "B", "A"}};
  for (const auto& channels : channel_lists)
    for (const ExrPrecision precision : {ExrPrecision::kHalf, ExrPrecision::kFloat}) {
      const std::map<std::string, std::string> metadata = {{"bakelight:a", "one"},
                                                           {"bakelight:b", "two words"}};
      writeExr(folder / "image.exr", numbered(channels), precision, metadata);
      const auto plain = readPlainExr(folder / "image.exr");
      ASSERT_TRUE(plain.has_value()) << channels[0];
      const Image other = pictureReaders().read_image(folder / "image.exr", NonFinite::kReject);
      EXPECT_EQ(plain->channel_names, other.channel_names);
      EXPECT_EQ(plain->values, other.values);
      EXPECT_EQ(plain->width, other.width);
      const Image written = numbered(channels);
      for (std::size_t c = 0; c < channels.size(); ++c) {
        const int found = plain->channelIndex(channels[c]);
        ASSERT_GE(found, 0) << channels[c];
        EXPECT_EQ(plain->texel(4, 2)[found], written.texel(4, 2)[c]);
      }
      const auto plain_metadata = plainExrMetadata(folder / "image.exr");
      ASSERT_TRUE(plain_metadata.has_value());
      EXPECT_EQ(*plain_metadata, metadata);
      const auto others = pictureReaders().read_metadata(folder / "image.exr");
      for (const auto& [key, value] : metadata) EXPECT_EQ(others.at(key), value);
    }
}

TEST(PlainExr, IsNothingElse) {
  const tests::TemporaryFolder folder;
  writePng(folder / "image.exr", numbered({"R", "G", "B"}));
  EXPECT_FALSE(readPlainExr(folder / "image.exr").has_value());
  writeExr(folder / "image.exr", numbered({"R", "G", "B"}));
  const Bytes whole = readFile(folder / "image.exr");
  writeFileAtomically(folder / "cut.exr", std::span(whole).first(whole.size() - 20));
  EXPECT_FALSE(readPlainExr(folder / "cut.exr").has_value());
  EXPECT_FALSE(readPlainExr(folder / "none.exr").has_value());
  EXPECT_FALSE(plainExrMetadata(folder / "none.exr").has_value());
}

// A copy of a tool without the modules beside it.
TEST(Module, IsMissedWithItsName) {
  const tests::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "bin");
  std::filesystem::copy_file(std::filesystem::path(BAKELIGHT_BIN_DIR) / "inspect", folder / "bin/inspect");
  writePng(folder / "image.png", numbered({"R", "G", "B"}));
  writeExr(folder / "image.exr", numbered({"R", "G", "B"}));
  const auto inspect = [&](const std::string& file) {
    std::ostringstream command;
    command << (folder / "bin/inspect") << ' ' << (folder / file) << " > " << (folder / "said.txt")
            << " 2>&1";
    return WEXITSTATUS(std::system(command.str().c_str()));
  };
  EXPECT_EQ(inspect("image.exr"), 0) << readTextFile(folder / "said.txt");
  EXPECT_EQ(inspect("image.png"), static_cast<int>(ExitStatus::kNotAvailable));
  EXPECT_THAT(readTextFile(folder / "said.txt"), HasSubstr("lib/bakelight/pictures.so"));
}

TEST(DataUri, CarriesBytesOfAnyNumber) {
  Bytes bytes;
  for (int size = 0; size < 20; ++size) {
    const DataUri read = readDataUri(dataUri("image/png", bytes));
    EXPECT_EQ(read.fault, "");
    EXPECT_EQ(read.media_type, "image/png");
    EXPECT_EQ(read.bytes, bytes);
    bytes.push_back(static_cast<std::byte>(37 * size + 200));
  }
  EXPECT_EQ(dataUri("a/b", std::as_bytes(std::span("light w", 7))),
            "data:a/b;base64,bGlnaHQgdw==");  // RFC 4648
}

}  // namespace
}  // namespace bakelight::formats
