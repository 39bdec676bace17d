#include "tools/dilate/dilate.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>

#include "formats/error.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"
#include "transport/nearest_texel.h"

using namespace bakelight;
using dilate::dilated;
using dilate::Method;
using formats::Image;

namespace {

std::vector<std::uint8_t> randomMembers(int width, int height, double share, unsigned seed) {
  std::mt19937 engine(seed);
  std::bernoulli_distribution is_member(share);
  std::vector<std::uint8_t> members(static_cast<std::size_t>(width) * height);
  for (auto& member : members) member = is_member(engine);
  members[engine() % members.size()] = 1;
  return members;
}

Image randomImage(int width, int height, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<float> value(-1, 5);
  Image image(width, height, {"R", "G", "index"});
  for (float& x : image.values) x = value(engine);
  return image;
}

TEST(NearestTexels, AreThoseOfASearchThroughAll) {
  for (const auto& [width, height, share, seed] : {std::tuple(23, 17, 0.02, 1u),
                                                   {23, 17, 0.3, 2u},
                                                   {1, 40, 0.1, 3u},
                                                   {40, 1, 0.1, 4u},
                                                   {31, 31, 0.005, 5u},
                                                   {20, 20, 0.0, 6u}}) {
    const auto members = randomMembers(width, height, share, seed);
    const auto nearest = transport::nearestTexels(members, width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        auto best = std::tuple(1 << 30, 0, 0);  // squared distance, column, row
        for (int row = 0; row < height; ++row)
          for (int column = 0; column < width; ++column)
            if (members[row * width + column] != 0)
              best = std::min(best,
                              std::tuple((column - x) * (column - x) + (row - y) * (row - y), column, row));
        ASSERT_EQ(nearest[y * width + x],
                  static_cast<std::uint32_t>(std::get<2>(best) * width + std::get<1>(best)))
            << seed << ": " << x << ", " << y;
      }
  }
}

TEST(Dilate, CoveredTexelsKeepTheirBitsAndOthersAreCopies) {
  const Image image = randomImage(33, 20, 1);
  const auto covered = randomMembers(33, 20, 0.1, 2);
  const dilate::Dilation result = dilated(image, covered, {Method::kNearest, 0});
  const auto nearest = transport::nearestTexels(covered, 33, 20);
  const auto holes = std::count(covered.begin(), covered.end(), 0);
  EXPECT_EQ(result.filled, holes);
  for (std::size_t i = 0; i < covered.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c)
      ASSERT_EQ(result.image.values[3 * i + c], image.values[3 * (covered[i] != 0 ? i : nearest[i]) + c]);
}

TEST(Dilate, ReachEndsTheFilling) {
  for (const Method method : {Method::kNearest, Method::kPushPull}) {
    Image image(15, 15, {"Y"});
    std::vector<std::uint8_t> covered(225, 0);
    image.texel(7, 7)[0] = 3;
    covered[7 * 15 + 7] = 1;
    const dilate::Dilation result = dilated(image, covered, {method, 5});
    int filled = 0;
    for (int y = 0; y < 15; ++y)
      for (int x = 0; x < 15; ++x) {
        const bool is_near = (x - 7) * (x - 7) + (y - 7) * (y - 7) <= 25;
        EXPECT_EQ(result.image.texel(x, y)[0], is_near ? 3 : 0);
        filled += is_near;
      }
    EXPECT_EQ(result.filled, filled - 1);
  }
}

TEST(PushPull, KeepsCoveredTexelsAndStaysBetweenThem) {
  const Image image = randomImage(37, 21, 5);
  const auto covered = randomMembers(37, 21, 0.15, 7);
  const Image filled = dilated(image, covered, {Method::kPushPull, 0}).image;
  for (std::size_t c = 0; c < 3; ++c) {
    float low = 1e9F, high = -1e9F;
    for (std::size_t i = 0; i < covered.size(); ++i)
      if (covered[i] != 0)
        low = std::min(low, image.values[3 * i + c]), high = std::max(high, image.values[3 * i + c]);
    for (std::size_t i = 0; i < covered.size(); ++i) {
      if (covered[i] != 0) {
        EXPECT_EQ(filled.values[3 * i + c], image.values[3 * i + c]);
      }
      EXPECT_GE(filled.values[3 * i + c], low);
      EXPECT_LE(filled.values[3 * i + c], high);
    }
  }
}

// A hole of 2 × 2: its parent has no value of its own, and takes the level above, bilinearly.
TEST(PushPull, AHoleIsTheBilinearValueOfTheCoarserLevel) {
  Image image(4, 4, {"Y"});
  std::vector<std::uint8_t> covered(16, 1);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) {
      image.texel(x, y)[0] = x >= 2 ? 8.0F : 0.0F;
      if (x < 2 && y < 2) covered[y * 4 + x] = 0;
    }
  const Image filled = dilated(image, covered, {Method::kPushPull, 0}).image;
  // 2 × 2 level: (hole, 8; 0, 8); its mean is 16/3, which the hole takes.
  const double hole = 16 / 3.0;
  const auto bilinear = [&](double right, double down) {
    return (1 - right) * (1 - down) * hole + right * 8 + (1 - right) * down * 0;
  };
  EXPECT_NEAR(filled.texel(0, 0)[0], hole, 1e-6);
  EXPECT_NEAR(filled.texel(1, 0)[0], bilinear(0.25, 0), 1e-6);
  EXPECT_NEAR(filled.texel(0, 1)[0], bilinear(0, 0.25), 1e-6);
  EXPECT_NEAR(filled.texel(1, 1)[0], bilinear(0.25, 0.25), 1e-6);
}

TEST(Dilate, ThreadsDoNotChangeABit) {
  const Image image = randomImage(150, 90, 8);
  const auto covered = randomMembers(150, 90, 0.05, 9);
  for (const Method method : {Method::kNearest, Method::kPushPull}) {
    const auto with = [&](std::size_t threads) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
      return dilated(image, covered, {method, 0}).image.values;
    };
    EXPECT_EQ(with(1), with(5));
  }
}

TEST(Dilate, MapsWithoutCoverageAreTold) {
  EXPECT_THROW(dilate::coveredTexels(Image(2, 2, {"R"}), "maps"), Error);
  EXPECT_THROW(dilate::coveredTexels(Image(2, 2, {"coverage"}), "maps"), Error);
  EXPECT_THROW(dilated(Image(2, 2, {"R"}), std::vector<std::uint8_t>(3, 1), {}), std::logic_error);
}

TEST(DilateTool, FillsAFileByTheMapsBesideIt) {
  const tests::TemporaryFolder folder;
  Image image(3, 1, {"index", "R"}), maps(3, 1, {"chart", "coverage"});
  image.values = {0, 0, 70001, 0.3F, 0, 0};
  maps.values = {-1, 0, 5, 2, -1, 0};
  const auto file = [&](const char* name) { return (folder / name).string(); };
  formats::writeExr(file("image.exr"), image, formats::ExrPrecision::kFloat);
  formats::writeExr(file("maps.exr"), maps, formats::ExrPrecision::kFloat);
  formats::writeExr(file("small.exr"), Image(2, 1, {"R"}), formats::ExrPrecision::kFloat);
  const std::string tool = std::string(BAKELIGHT_BIN_DIR) + "/dilate --maps " + file("maps.exr");
  const auto done = tests::shell(tool + " --image " + file("image.exr") + " --dilated " + file("out.exr"));
  ASSERT_EQ(done.status, 0) << done.output;
  const Image out = formats::readImage(file("out.exr"));
  for (int x = 0; x < 3; ++x) {
    EXPECT_EQ(out.texel(x, 0)[out.channelIndex("index")], 70001);
    EXPECT_EQ(out.texel(x, 0)[out.channelIndex("R")], 0.3F);
  }
  const auto failed = tests::shell(tool + " --image " + file("small.exr") + " --dilated " + file("out.exr"));
  EXPECT_EQ(failed.status, 2);
  EXPECT_THAT(failed.output, testing::HasSubstr("3 × 1 texels, as the maps have"));
}

}  // namespace
