#include "tools/simplify/colors.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "formats/error.h"
#include "tests/support/shapes.h"
#include "tests/support/temporary_folder.h"
#include "tools/simplify/simplify.h"
#include "transport/color.h"

namespace bakelight::simplify {
namespace {

using namespace bakelight::tests;

// Unit square in the xy plane, `cells` × `cells` quads, with texture coordinates u = x, v = y.
TriangleMesh square(int cells) {
  TriangleMesh mesh;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      const float x = static_cast<float>(i) / static_cast<float>(cells),
                  y = static_cast<float>(j) / static_cast<float>(cells);
      mesh.positions.push_back({x, y, 0});
      mesh.normals.push_back({0, 0, 1});
      mesh.texcoords.push_back({x, y});
    }
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const auto a = static_cast<std::uint32_t>(j * (cells + 1) + i),
                 b = a + static_cast<std::uint32_t>(cells) + 1;
      mesh.triangles.push_back({a, a + 1, b + 1});
      mesh.triangles.push_back({a, b + 1, b});
    }
  return mesh;
}

TEST(Colors, NothingToCarryGivesNothing) {
  TriangleMesh plain = square(2);
  EXPECT_TRUE(carryAlbedo(plain, nullptr, plain, "x.obj").empty());
}

// A linear function of the place is its own hat-weighted mean, away from the border.
TEST(Colors, VertexColoursComeBackWhereTheyAreLinear) {
  TriangleMesh source = square(8);
  for (const auto& p : source.positions) source.colors.push_back({p[0], p[1], 0.25f});
  const TriangleMesh target = square(5);
  const auto albedo = carryAlbedo(source, nullptr, target, "x.ply");
  ASSERT_EQ(albedo.size(), target.vertexCount());
  for (int j = 1; j < 5; ++j)
    for (int i = 1; i < 5; ++i) {
      const auto& color = albedo[j * 6 + i];
      EXPECT_NEAR(color[0], i / 5.0, 0.01);
      EXPECT_NEAR(color[1], j / 5.0, 0.01);
      EXPECT_NEAR(color[2], 0.25, 1e-6);
    }
}

// Upper left corner of the image is u = 0, v = 1.
TEST(Colors, ATextureIsTheRightWayUp) {
  formats::Image texture(2, 2, {"R", "G", "B"});
  texture.texel(0, 0)[0] = 1;  // upper left: red
  texture.texel(1, 0)[1] = 1;  // upper right: green
  texture.texel(0, 1)[2] = 1;  // lower left: blue
  const TriangleMesh target = square(8);
  const auto albedo = carryAlbedo(target, &texture, target, "x.obj");
  ASSERT_EQ(albedo.size(), target.vertexCount());
  const auto at = [&](int i, int j) { return albedo[j * 9 + i]; };
  EXPECT_GT(at(2, 6)[0], 0.7);
  EXPECT_GT(at(6, 6)[1], 0.7);
  EXPECT_GT(at(2, 2)[2], 0.7);
  EXPECT_LT(at(6, 2)[0] + at(6, 2)[1] + at(6, 2)[2], 0.3);
}

// A checkerboard far finer than the vertices comes down to its mean, linear light.
TEST(Colors, FineTexturesAreFiltered) {
  formats::Image texture(251, 251, {"R", "G", "B"});
  for (int y = 0; y < 251; ++y)
    for (int x = 0; x < 251; ++x)
      for (int c = 0; c < 3; ++c) texture.texel(x, y)[c] = (x / 2 + y / 2) % 2 == 0 ? 1.0f : 0.0f;
  const TriangleMesh target = square(4);
  const auto albedo = carryAlbedo(target, &texture, target, "x.obj");
  double mean = 0;
  for (const auto& color : albedo) {
    EXPECT_NEAR(color[0], 0.5, 0.1);
    mean += color[0] / static_cast<double>(albedo.size());
  }
  EXPECT_NEAR(mean, 0.5, 0.05);
}

TEST(Colors, ATextureNeedsTextureCoordinates) {
  TriangleMesh bare = square(2);
  bare.texcoords.clear();
  const formats::Image texture(1, 1, {"R", "G", "B"});
  EXPECT_THROW(carryAlbedo(bare, &texture, bare, "bare.obj"), Error);
}

TEST(Colors, EightBitTexturesAreDisplayCodes) {
  const TemporaryFolder folder;
  formats::Image image(1, 1, {"R", "G", "B"});
  image.values = {0.5f, 0.25f, 1.0f};
  formats::writePng(folder.path() / "a.png", image);
  formats::writeExr(folder.path() / "a.exr", image, formats::ExrPrecision::kFloat);
  const formats::Image png = readAlbedoTexture(folder.path() / "a.png");
  const formats::Image exr = readAlbedoTexture(folder.path() / "a.exr");
  EXPECT_NEAR(png.texel(0, 0)[0], transport::linearFromSrgb(128 / 255.0f), 1e-6);
  EXPECT_EQ(exr.texel(0, 0)[0], 0.5f);
}

TEST(Colors, SurviveSimplification) {
  TriangleMesh ball = icosphere(4);
  for (const auto& p : ball.positions) ball.colors.push_back({p[1] > 0 ? 0.9f : 0.1f, 0.5f, 0.5f});
  SimplifyOptions options;
  options.triangles = 1000;
  const TriangleMesh simple = simplify(ball, options, "ball").mesh;
  const auto albedo = carryAlbedo(ball, nullptr, simple, "ball");
  ASSERT_EQ(albedo.size(), simple.vertexCount());
  for (std::size_t v = 0; v < albedo.size(); ++v) {
    const float height = simple.positions[v][1];
    if (std::abs(height) > 0.35) {
      EXPECT_NEAR(albedo[v][0], height > 0 ? 0.9 : 0.1, 1e-3);
    }
  }
}

TEST(Colors, SameBytesWithAnyNumberOfThreads) {
  TriangleMesh ball = icosphere(3);
  for (const auto& n : ball.normals) ball.colors.push_back({n[0] * n[0], n[1] * n[1], n[2] * n[2]});
  const TriangleMesh target = icosphere(2);
  const auto many = carryAlbedo(ball, nullptr, target, "ball");
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(carryAlbedo(ball, nullptr, target, "ball"), many);
}

}  // namespace
}  // namespace bakelight::simplify
