// Shading by normals from pack to picture. With --picture FILE.png it draws the picture of
// docs/ADDING_A_TECHNIQUE.md instead.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>

#include "formats/compare.h"
#include "formats/error.h"
#include "formats/field_list.h"
#include "formats/pack.h"
#include "tests/e2e/made_packs.h"
#include "tests/e2e/silhouette.h"
#include "tests/example_technique/made_ball.h"
#include "tests/example_technique/normal_reflection.h"
#include "tests/example_technique/normal_shading.h"
#include "tests/example_technique/normal_technique.h"
#include "tests/support/temporary_folder.h"
#include "tools/inspect/inspect.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/renderer.h"
#include "transport/cpu_renderer.h"

namespace bakelight::example {
namespace {

using formats::Precision;
using testing::HasSubstr;
using transport::Float3;
using transport::Vec3;

formats::Pack examplePack(Precision precision = Precision::kFloat16, int rings = 40) {
  formats::Pack pack = tests::wavyPack(1, rings);
  pack.appearances.front().reflection = NormalReflection{madeBallPicture(128, precision)};
  return pack;
}

const NormalReflection& partOf(const formats::Pack& pack) {
  return *pack.appearances.front().reflection.as<NormalReflection>();
}

transport::Lighting whiteLighting(float radiance) {
  transport::Lighting lighting;
  lighting.distant = transport::uniformLight(1, {radiance, radiance, radiance});
  lighting.backdrop = formats::Image(4, 2, {"R", "G", "B"});
  return lighting;
}

constexpr formats::FrameSettings kFrame{.width_px = 320,
                                        .height_px = 240,
                                        .supersampling = 2,
                                        .yaw_deg = 30,
                                        .pitch_deg = 20,
                                        .auto_exposure = false,
                                        .background = formats::Background::kBlack};

// ---- the pack

TEST(ExamplePack, HoldsThePartAtEachPrecisionPlainAndCompressed) {
  for (const auto precision : {Precision::kFloat32, Precision::kFloat16, Precision::kUint8})
    for (const bool draco : {false, true}) {
      const formats::Pack pack = examplePack(precision, 12);
      const formats::Pack read =
          formats::decodePack(formats::encodePack(pack, {.draco = draco}, "a.glb"), "a.glb");
      ASSERT_NE(normalReflectionOf(read), nullptr);
      const formats::PackImage &picture = partOf(read).picture, &source = partOf(pack).picture;
      EXPECT_EQ(picture.width, source.width);
      EXPECT_EQ(picture.channels, source.channels);
      EXPECT_EQ(picture.texels.decode(), source.texels.decode());
    }
}

TEST(ExamplePack, IsComparedFieldByField) {
  const formats::Pack pack = examplePack(Precision::kFloat32, 12);
  EXPECT_TRUE(formats::comparePacks(pack, pack, {}).passes());
  formats::Pack other = pack;
  NormalReflection spoiled = partOf(pack);
  std::vector<float> texels = spoiled.picture.texels.decode();
  texels[1000] += 0.25F;
  spoiled.picture.texels = formats::encodeTable(texels, 3, Precision::kFloat32, "made", "picture");
  other.appearances.front().reflection = spoiled;
  EXPECT_FALSE(formats::comparePacks(other, pack, {}).passes());
  EXPECT_TRUE(formats::comparePacks(other, pack, {.maximum = 0.26, .relative = 1}).passes());
}

// Draco reorders vertices: what belongs to them follows, and the picture stays.
TEST(ExamplePack, PermutingVerticesLeavesThePictureAlone) {
  formats::Pack pack = examplePack(Precision::kFloat32, 12);
  const formats::Pack before = pack;
  std::vector<std::uint32_t> order(pack.mesh.vertexCount());
  for (std::size_t v = 0; v < order.size(); ++v) order[v] = static_cast<std::uint32_t>(order.size() - 1 - v);
  formats::permuteVertices(pack, order);
  EXPECT_EQ(pack.mesh.positions.front(), before.mesh.positions.back());
  EXPECT_EQ(partOf(pack).picture.texels.decode(), partOf(before).picture.texels.decode());
}

TEST(ExamplePack, ThatBreaksARuleIsRefusedByItsName) {
  const auto refusal = [](const std::function<void(formats::PackImage&)>& spoil) -> std::string {
    formats::Pack pack = examplePack(Precision::kFloat32, 12);
    NormalReflection part = partOf(pack);
    spoil(part.picture);
    pack.appearances.front().reflection = part;
    try {
      formats::encodePack(pack, {}, "a.glb");
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal([](formats::PackImage&) {}), "");
  EXPECT_THAT(refusal([](formats::PackImage& p) {
                p.channels = {"X", "Y", "Z"};
              }),
              testing::AllOf(HasSubstr("a.glb"), HasSubstr("picture"), HasSubstr("R, G and B")));
  EXPECT_THAT(refusal([](formats::PackImage& p) { p.width *= 2, p.height /= 2; }), HasSubstr("a square"));
  EXPECT_THAT(refusal([](formats::PackImage& p) { p.height += 1; }), HasSubstr("picture"));
}

TEST(ExamplePack, OfAnUnknownKindNamesWhatIsKnown) {
  const formats::Bytes bytes = formats::encodePack(examplePack(Precision::kUint8, 12), {}, "a.glb");
  formats::reflectionKinds().pop_back();
  std::string message;
  try {
    formats::decodePack(bytes, "a.glb");
  } catch (const Error& error) {
    message = error.what();
  }
  formats::reflectionKinds().push_back(formats::PackPartKind::of<NormalReflection>());
  EXPECT_THAT(message,
              testing::AllOf(
                  HasSubstr("normals"),
                  HasSubstr("lambert, phong, ggx, table, radiance_transfer_texture, btf or translucency")));
}

TEST(ExamplePack, IsInspectedAndPreviewedWithoutAnotherLine) {
  const tests::TemporaryFolder folder;
  formats::writePack(folder / "example.glb", examplePack(Precision::kUint8, 12), {});
  const auto inspection =
      inspect::inspectFile(folder / "example.glb", inspect::PreviewOptions{.size_px = 64});
  const std::string text = inspect::asText(inspection.summary);
  for (const char* word : {"normals", "picture", "128"}) EXPECT_THAT(text, HasSubstr(word));
  const formats::Image& preview = inspection.preview->image;
  const float* middle = preview.texel(32, 32);
  EXPECT_GT(middle[0], middle[2]) << "clay is red";
}

// ---- the picture: physics

class ExampleShading : public testing::Test {
 protected:
  // At the middle of each triangle.
  std::vector<Float3> radianceOf(const formats::Pack& pack, const Vec3& eye, float light) {
    const auto shading = transport::makePackShading(pack);
    const transport::ShLight uniform =
        transport::uniformLight(shading->needs().sh_order, {light, light, light});
    shading->setLight(uniform, {});
    shading->setView(eye);
    std::vector<transport::SurfaceHit> hits;
    for (std::uint32_t t = 0; t < pack.mesh.triangleCount(); ++t) hits.push_back({t, 1.0F / 3, 1.0F / 3});
    std::vector<Float3> radiance(hits.size());
    shading->radianceAt(hits, radiance);
    return radiance;
  }
};

// A ball that shows 1 everywhere is a white furnace: a body under it sends what it receives.
TEST_F(ExampleShading, WhitePictureSendsTheLightBack) {
  formats::Pack pack = examplePack(Precision::kFloat32, 16);
  pack.appearances.front().reflection =
      NormalReflection{{8,
                        8,
                        {"R", "G", "B"},
                        formats::encodeTable(std::vector<float>(192, 1.0F), 3, Precision::kFloat32, "", "")}};
  for (const float light : {1.0F, 2.5F})
    for (const Float3& radiance : radianceOf(pack, {2, 1, 3}, light))
      for (const float value : radiance) ASSERT_NEAR(value, light, 1e-6F * light);
}

TEST_F(ExampleShading, IsLinearInTheLight) {
  const formats::Pack pack = examplePack(Precision::kFloat32, 16);
  const auto once = radianceOf(pack, {2, 1, 3}, 1), thrice = radianceOf(pack, {2, 1, 3}, 3);
  for (std::size_t i = 0; i < once.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(thrice[i][c], 3 * once[i][c], 1e-5F);
}

// A ball from far away shows the picture itself.
TEST_F(ExampleShading, ABallFromAfarIsThePicture) {
  formats::Pack pack = tests::spherePack(1, 64);
  pack.appearances.front().reflection = NormalReflection{madeBallPicture(256, Precision::kFloat32)};
  const formats::PackImage& picture = partOf(pack).picture;
  const std::vector<float> texels = picture.texels.decode();
  const auto radiance = radianceOf(pack, {0, 0, 1e4}, 1);
  std::size_t seen = 0;
  for (std::size_t t = 0; t < radiance.size(); ++t) {
    Vec3 middle = Vec3::Zero();
    for (const std::uint32_t corner : pack.mesh.triangles[t])
      middle += transport::vec3(pack.mesh.positions[corner]);
    middle.normalize();
    if (middle.z() < 0.3) continue;  // towards the rim a texel spans many normals
    ++seen;
    const auto x = static_cast<std::size_t>((0.5 + 0.5 * middle.x()) * picture.width);
    const auto y = static_cast<std::size_t>((0.5 - 0.5 * middle.y()) * picture.height);
    const float* texel = &texels[3 * (y * static_cast<std::size_t>(picture.width) + x)];
    for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(radiance[t][c], texel[c], 0.05) << middle.transpose();
  }
  EXPECT_GT(seen, radiance.size() / 5);
}

// ---- the player

transport::CpuPicture cpuPicture(const formats::Pack& pack, const transport::Lighting& lighting,
                                 const transport::OrbitCamera& camera) {
  const auto shading = transport::makePackShading(pack);
  shading->setLight(lighting.distant, {});
  shading->setView(camera.eye());
  const transport::RayScene scene(pack.mesh);
  return transport::renderOnCpu(scene, transport::radianceOf(*shading), camera,
                                {kFrame.width_px, kFrame.height_px, kFrame.supersampling}, [](const Vec3&) {
                                  return formats::Float4{0, 0, 0, 1};
                                });
}

class ExamplePlayer : public testing::Test {
 protected:
  player::HeadlessContext context_;
};

TEST_F(ExamplePlayer, ShowsWhatTheCpuShows) {
  for (const auto precision : {Precision::kFloat32, Precision::kUint8}) {
    const formats::Pack pack = examplePack(precision);
    const transport::Lighting lighting = whiteLighting(0.75F);
    player::Renderer renderer(pack, lighting);
    renderer.draw(kFrame);
    const formats::Image played = renderer.target().displayImage(1);

    const transport::OrbitCamera camera = transport::frameCamera(kFrame, renderer.bounds());
    const transport::CpuPicture picture = cpuPicture(pack, lighting, camera);
    const formats::Image expected = transport::encodeForDisplay(picture.linear, 1);
    const std::vector<bool> silhouette = tests::silhouettePixels(
        pack.mesh, picture, camera, {kFrame.width_px, kFrame.height_px, kFrame.supersampling});
    std::size_t compared = 0;
    for (int y = 0; y < kFrame.height_px; ++y)
      for (int x = 0; x < kFrame.width_px; ++x) {
        if (silhouette[static_cast<std::size_t>(y * kFrame.width_px + x)]) continue;
        if (expected.texel(x, y)[0] > 0) ++compared;
        for (int c = 0; c < 4; ++c)
          ASSERT_NEAR(played.texel(x, y)[c], expected.texel(x, y)[c], 1.001 / 255) << x << ", " << y;
      }
    EXPECT_GT(compared, 10000u);
  }
}

TEST_F(ExamplePlayer, AddsUpTheLightThatIsDistantAndNear) {
  const formats::Pack pack = examplePack();
  const auto middle = [&](const transport::Lighting& lighting) {
    player::Renderer renderer(pack, lighting);
    renderer.draw(kFrame);
    return renderer.target().linearImage().texel(kFrame.width_px / 2, kFrame.height_px / 2)[0];
  };
  const float once = middle(whiteLighting(1));
  EXPECT_GT(once, 0.01F);
  EXPECT_NEAR(middle(whiteLighting(2)) / once, 2, 1e-4);
  // A lamp around the body is a uniform light, too.
  formats::Emitter lamp;
  lamp.shape = formats::Emitter::Shape::kSphere;
  lamp.position = {0, 0, 0};
  lamp.radius = 40;
  lamp.radiance = {0.5F, 0.5F, 0.5F};
  transport::Lighting both = whiteLighting(1);
  both.near.emitters = {lamp};
  EXPECT_NEAR(middle(both) / once, 1.5, 1e-3);
}

TEST(ExampleTechnique, AsksForTheMeanLightAlone) {
  const formats::Pack pack = examplePack(Precision::kUint8, 12);
  EXPECT_STREQ(player::techniqueFor(pack).name, "normals");
  EXPECT_EQ(player::lightOrder(pack), 1);
  EXPECT_STREQ(player::techniqueFor(tests::spherePack(3, 8)).name, "vertices");
}

void drawPicture(const std::filesystem::path& path) {
  constexpr int kEdge = 240;
  const player::HeadlessContext context;
  player::Renderer renderer(examplePack(Precision::kFloat16, 96), whiteLighting(1));
  formats::FrameSettings settings = kFrame;
  settings.width_px = settings.height_px = kEdge;
  settings.supersampling = 4;
  settings.distance *= 0.8;
  renderer.draw(settings);
  const formats::Image body = renderer.target().displayImage(1);

  const formats::PackImage ball = madeBallPicture(kEdge, Precision::kFloat32);
  formats::Image linear(kEdge, kEdge, {"R", "G", "B", "A"});
  const std::vector<float> texels = ball.texels.decode();
  for (std::size_t i = 0; i < texels.size() / 3; ++i) {
    std::copy_n(&texels[3 * i], 3, &linear.values[4 * i]);
    linear.values[4 * i + 3] = 1;
  }
  const formats::Image shown = transport::encodeForDisplay(linear, 1);
  formats::Image both(2 * kEdge, kEdge, {"R", "G", "B", "A"});
  for (int y = 0; y < kEdge; ++y) {
    std::copy_n(shown.texel(0, y), 4 * kEdge, both.texel(0, y));
    std::copy_n(body.texel(0, y), 4 * kEdge, both.texel(kEdge, y));
  }
  formats::writePng(path, both);
}

}  // namespace
}  // namespace bakelight::example

int main(int argc, char** argv) {
  using namespace bakelight;
  // The three lines.
  formats::reflectionKinds().push_back(formats::PackPartKind::of<example::NormalReflection>());
  transport::shadingTechniques().push_back(example::normalShading());
  player::techniques().push_back(example::normalTechnique());

  testing::InitGoogleMock(&argc, argv);
  if (argc == 3 && std::strcmp(argv[1], "--picture") == 0) {
    example::drawPicture(argv[2]);
    return 0;
  }
  return RUN_ALL_TESTS();
}
