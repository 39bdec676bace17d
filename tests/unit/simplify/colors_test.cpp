#include "tools/simplify/colors.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "formats/error.h"
#include "formats/file.h"
#include "tests/support/shapes.h"
#include "tests/support/temporary_folder.h"
#include "tools/simplify/albedo_map.h"
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

using formats::AlbedoTexture;
using formats::Image;
using formats::MeshImport;
using Wrap = AlbedoTexture::Wrap;

std::vector<Float3> carried(const TriangleMesh& source, const TriangleMesh& target) {
  return carryAlbedo({.mesh = source}, target, "x.obj").colors;
}

// With one picture on the whole mesh.
std::vector<Float3> carried(const TriangleMesh& source, const Image& picture, const TriangleMesh& target) {
  const TemporaryFolder folder;
  formats::writeExr(folder.path() / "picture.exr", picture, formats::ExrPrecision::kFloat);
  MeshImport import{.mesh = source};
  replaceAlbedo(import, folder.path() / "picture.exr", "x.obj");
  return carryAlbedo(import, target, "x.obj").colors;
}

Image plainImage(const Float3& color) {
  Image image(1, 1, {"R", "G", "B"});
  image.values = {color[0], color[1], color[2]};
  return image;
}

formats::Bytes pngBytes(const Image& image) {
  const TemporaryFolder folder;
  formats::writePng(folder.path() / "a.png", image);
  return formats::readFile(folder.path() / "a.png");
}

TEST(Colors, NothingToCarryGivesNothing) {
  TriangleMesh plain = square(2);
  EXPECT_TRUE(carried(plain, plain).empty());
}

// A linear function of the place is its own hat-weighted mean, away from the border.
TEST(Colors, VertexColorsComeBackWhereTheyAreLinear) {
  TriangleMesh source = square(8);
  for (const auto& p : source.positions) source.colors.push_back({p[0], p[1], 0.25f});
  const TriangleMesh target = square(5);
  const auto albedo = carried(source, target);
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
  const auto albedo = carried(target, texture, target);
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
  const auto albedo = carried(target, texture, target);
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
  MeshImport import{.mesh = bare};
  EXPECT_THROW(replaceAlbedo(import, "a.png", "bare.obj"), Error);
}

TEST(Colors, EightBitTexturesAreDisplayCodes) {
  const TemporaryFolder folder;
  formats::Image image(1, 1, {"R", "G", "B"});
  image.values = {0.5f, 0.25f, 1.0f};
  formats::writePng(folder.path() / "a.png", image);
  formats::writeExr(folder.path() / "a.exr", image, formats::ExrPrecision::kFloat);
  std::vector<std::string> notes;
  const auto read = [&](const std::string& name) {
    return readAlbedoTexture({name, folder.path() / name}, "x.obj", notes).texel(0, 0)[0];
  };
  EXPECT_NEAR(read("a.png"), transport::linearFromSrgb(128 / 255.0f), 1e-6);
  EXPECT_EQ(read("a.exr"), 0.5f);
  EXPECT_TRUE(notes.empty());
}

TEST(Colors, EmbeddedPicturesAreRead) {
  const TemporaryFolder folder;
  Image image(2, 1, {"R", "G", "B"});
  image.values = {1, 0, 0, 0, 0, 1};
  std::vector<std::string> notes;
  const Image png = readAlbedoTexture({"image 2 of a.glb", {}, pngBytes(image)}, "a.glb", notes);
  EXPECT_EQ(png.values, image.values);
  image.values = {0.5f, 0, 0, 0, 0, 7};
  formats::writeExr(folder.path() / "a.exr", image, formats::ExrPrecision::kFloat);
  const Image exr =
      readAlbedoTexture({"image 3 of a.glb", {}, formats::readFile(folder.path() / "a.exr")}, "a.glb", notes);
  EXPECT_EQ(exr.values, (std::vector<float>{0.5f, 0, 0, 0, 0, 1}));
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("image 3 of a.glb: 1 texels"), std::string::npos) << notes[0];
}

// Where the colour is seen through is no question here: what alpha hides counts, too.
TEST(Colors, AlphaIsNotLookedAt) {
  Image image(1, 1, {"R", "G", "B", "A"});
  image.values = {1, 0, 1, 0};
  std::vector<std::string> notes;
  EXPECT_EQ(readAlbedoTexture({"a", {}, pngBytes(image)}, "a.glb", notes).values,
            (std::vector<float>{1, 0, 1}));
}

TEST(Colors, WhatIsNoPictureIsNamed) {
  std::vector<std::string> notes;
  const auto messageOf = [&](const AlbedoTexture& texture) -> std::string {
    try {
      readAlbedoTexture(texture, "model.glb", notes);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  const std::string cut = messageOf({"image 2 of model.glb", {}, [] {
                                       formats::Bytes bytes = pngBytes(plainImage({1, 1, 1}));
                                       bytes.resize(40);
                                       return bytes;
                                     }()});
  EXPECT_NE(cut.find("image 2 of model.glb"), std::string::npos) << cut;
  const std::string text = messageOf({"image 2 of model.glb", {}, formats::Bytes(9, std::byte{'x'})});
  EXPECT_NE(text.find("image 2 of model.glb"), std::string::npos) << text;
  EXPECT_NE(text.find("no picture"), std::string::npos) << text;
  const std::string missing = messageOf({"skin.png", "folder/skin.png"});
  EXPECT_NE(missing.find("folder/skin.png"), std::string::npos) << missing;
  EXPECT_NE(missing.find("model.glb"), std::string::npos) << missing;
}

TEST(Colors, OutsideOfThePictureItIsWrapped) {
  Image image(2, 1, {"R", "G", "B"});
  image.values = {1, 0, 0, 0, 0, 1};  // left red, right blue
  const auto redAt = [&](double u, Wrap wrap) { return AlbedoMap(image, wrap, wrap).colorAt(u, 0.5, 0)[0]; };
  for (const auto wrap : {Wrap::kRepeat, Wrap::kMirror, Wrap::kClamp}) {
    EXPECT_NEAR(redAt(0.25, wrap), 1, 1e-9);
    EXPECT_NEAR(redAt(0.75, wrap), 0, 1e-9);
  }
  EXPECT_NEAR(redAt(1.25, Wrap::kRepeat), 1, 1e-9);
  EXPECT_NEAR(redAt(1.25, Wrap::kMirror), 0, 1e-9);
  EXPECT_NEAR(redAt(1.25, Wrap::kClamp), 0, 1e-9);
  EXPECT_NEAR(redAt(-0.25, Wrap::kRepeat), 0, 1e-9);
  EXPECT_NEAR(redAt(-0.25, Wrap::kMirror), 1, 1e-9);
  EXPECT_NEAR(redAt(-7, Wrap::kClamp), 1, 1e-9);
  EXPECT_NEAR(redAt(0, Wrap::kRepeat), 0.5, 1e-9);
  EXPECT_NEAR(redAt(0, Wrap::kMirror), 1, 1e-9);
}

// Left half in one material, right half in the other, the vertices on the line twice.
struct TwoMaterials {
  MeshImport import;
  TwoMaterials() {
    TriangleMesh half = square(4);
    for (auto& p : half.positions) p[0] /= 2;
    import.mesh = half;
    for (auto& p : half.positions) p[0] += 0.5f;
    append(import.mesh, half);
    import.mesh.texcoords.insert(import.mesh.texcoords.end(), half.texcoords.begin(), half.texcoords.end());
    import.mesh.triangle_materials.assign(2 * half.triangleCount(), 0);
    std::fill(import.mesh.triangle_materials.begin() + static_cast<int>(half.triangleCount()),
              import.mesh.triangle_materials.end(), 1);
    import.mesh.material_names = {"left", "right", "unused"};
  }
};

TEST(Colors, DoNotBleedOverBordersOfMaterials) {
  MeshImport import = TwoMaterials().import;
  for (const auto& p : import.mesh.positions) import.mesh.colors.push_back({0, 0, p[0] < 0.5f ? 0.2f : 0.8f});
  const std::size_t half = import.mesh.vertexCount() / 2;
  for (std::size_t v = 0; v < half; ++v) import.mesh.colors[v] = {1, 0, 0};
  for (std::size_t v = half; v < 2 * half; ++v) import.mesh.colors[v] = {0, 1, 0};
  SimplifyOptions options;
  options.triangles = 8;
  const TriangleMesh simple = simplify(import.mesh, options, "x.obj").mesh;
  const auto albedo = carryAlbedo(import, simple, "x.obj").colors;
  ASSERT_EQ(albedo.size(), simple.vertexCount());
  for (std::size_t t = 0; t < simple.triangleCount(); ++t)
    for (const std::uint32_t v : simple.triangles[t])
      EXPECT_EQ(albedo[v], simple.triangle_materials[t] == 0 ? (Float3{1, 0, 0}) : (Float3{0, 1, 0}));
}

// A coat of paint just above the wood: the wood's triangles, moved up into the coat, still have the wood's colour.
TEST(Colors, ComeFromTheSameMaterialThoughAnotherIsNearer) {
  MeshImport import;
  for (const float z : {0.0f, 0.01f}) {
    const auto first = static_cast<std::uint32_t>(import.mesh.vertexCount());
    for (const auto& [x, y] : {std::pair{0.0f, 0.0f}, {1.0f, 0.0f}, {1.0f, 1.0f}, {0.0f, 1.0f}}) {
      import.mesh.positions.push_back({x, y, z});
      import.mesh.colors.push_back(z == 0 ? Float3{1, 0, 0} : Float3{0, 1, 0});
    }
    import.mesh.triangles.push_back({first, first + 1, first + 2});
    import.mesh.triangles.push_back({first, first + 2, first + 3});
  }
  import.mesh.triangle_materials = {0, 0, 1, 1};
  import.mesh.material_names = {"wood", "paint"};
  TriangleMesh moved = import.mesh;
  for (std::size_t v = 0; v < 4; ++v) moved.positions[v][2] = 0.009f;
  const auto albedo = carryAlbedo(import, moved, "x.obj").colors;
  ASSERT_EQ(albedo.size(), 8u);
  for (std::size_t v = 0; v < 8; ++v) EXPECT_EQ(albedo[v], (v < 4 ? Float3{1, 0, 0} : Float3{0, 1, 0})) << v;
}

// Each has its picture, looked up elsewhere than the mesh's own texture coordinates say; the unused one's,
// which does not exist, is not asked for.
TEST(Colors, EachMaterialHasItsTexture) {
  MeshImport import = TwoMaterials().import;
  Image halves(2, 1, {"R", "G", "B"});
  halves.values = {1, 0, 0, 0, 0, 1};
  import.textures = {{"nowhere", "nowhere.png"},
                     {"halves", {}, pngBytes(halves), Wrap::kClamp, Wrap::kClamp},
                     { "green",
                       {},
                       pngBytes(plainImage({0, 1, 0})) }};
  import.material_textures = {1, 2, 0};
  import.texture_lookups.assign(import.mesh.vertexCount(), {0.9f, 0.5f});
  import.mesh.colors.assign(import.mesh.vertexCount(), {1, 0.5f, 0.25f});
  const auto albedo = carryAlbedo(import, import.mesh, "x.obj").colors;
  for (std::size_t t = 0; t < import.mesh.triangleCount(); ++t)
    for (const std::uint32_t v : import.mesh.triangles[t])
      EXPECT_EQ(albedo[v],
                import.mesh.triangle_materials[t] == 0 ? (Float3{0, 0, 0.25f}) : (Float3{0, 0.5f, 0}));
}

TEST(Colors, AGivenTextureReplacesTheMeshsOwn) {
  const TemporaryFolder folder;
  formats::writePng(folder.path() / "blue.png", plainImage({0, 0, 1}));
  MeshImport import = TwoMaterials().import;
  import.textures = {{ "nowhere", "nowhere.png" }};
  import.material_textures = {0, -1, -1};
  import.texture_lookups = import.mesh.texcoords;
  import.mesh.colors.assign(import.mesh.vertexCount(), {1, 0, 0});
  EXPECT_EQ(replaceAlbedo(import, folder.path() / "blue.png", "x.obj").size(), 2u);
  for (const Float3& color : carryAlbedo(import, import.mesh, "x.obj").colors)
    EXPECT_EQ(color, (Float3{0, 0, 1}));
}

TEST(Colors, SurviveSimplification) {
  TriangleMesh ball = icosphere(4);
  for (const auto& p : ball.positions) ball.colors.push_back({p[1] > 0 ? 0.9f : 0.1f, 0.5f, 0.5f});
  SimplifyOptions options;
  options.triangles = 1000;
  const TriangleMesh simple = simplify(ball, options, "ball").mesh;
  const auto albedo = carried(ball, simple);
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
  const auto many = carried(ball, target);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(carried(ball, target), many);
}

}  // namespace
}  // namespace bakelight::simplify
