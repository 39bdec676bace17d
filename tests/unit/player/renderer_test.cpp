#include "tools/player/renderer.h"

#include <cmath>

#include "tests/e2e/made_packs.h"
#include "tools/player/gl/gl_context.h"

namespace bakelight::player {
namespace {

using tests::spherePack;
using transport::Vec3;

transport::Lighting uniformLighting(int order, float radiance) {
  transport::Lighting lighting;
  lighting.backdrop = formats::Image(8, 4, {"R", "G", "B"});
  std::fill(lighting.backdrop.values.begin(), lighting.backdrop.values.end(), radiance);
  lighting.distant = transport::uniformLight(order, {radiance, radiance, radiance});
  return lighting;
}

// Nothing to see but the backdrop.
formats::Pack emptyPack() {
  formats::Pack pack = spherePack(2, 4);
  pack.mesh.triangles.clear();
  return pack;
}

// Dark, with one bright texel patch around `direction` in the colour given.
void addPatch(formats::Image& image, const Vec3& direction, const formats::Float3& radiance) {
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const auto center = transport::directionOfLatLong((x + 0.5) / image.width, (y + 0.5) / image.height);
      if (center.dot(direction.normalized()) > std::cos(0.1))
        std::copy(radiance.begin(), radiance.end(), image.texel(x, y));
    }
}

class RendererTest : public testing::Test {
 protected:
  HeadlessContext context_;
};

TEST_F(RendererTest, FurnaceIsWhite) {
  // A convex body of albedo 1 under a uniform sky of 1 sends 1 in all directions: it cannot be told from the
  // sky.
  for (const int order : {1, 2, 3, 10}) {
    Renderer renderer(spherePack(order, 32), uniformLighting(order, 1));
    const formats::FrameSettings settings{.width_px = 60, .height_px = 40, .auto_exposure = false};
    renderer.draw(settings);
    const auto linear = renderer.target().linearImage();
    for (const float value : linear.values) EXPECT_NEAR(value, 1, 1e-4) << order;
    const auto display = renderer.target().displayImage(renderer.exposure(settings));
    ASSERT_EQ(display.values.size(), 60u * 40u * 4u);
    for (const float value : display.values) EXPECT_EQ(std::lround(255 * value), 255) << order;
  }
}

TEST_F(RendererTest, BaseColorMultipliesTheSurfaceAlone) {
  formats::Pack pack = spherePack(2, 32);
  pack.appearances[0].base_color = {0.25f, 0.5f, 0.75f};
  Renderer renderer(pack, uniformLighting(2, 1));
  renderer.draw({.width_px = 65, .height_px = 65});
  const auto linear = renderer.target().linearImage();
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(linear.texel(32, 32)[c], pack.appearances[0].base_color[c], 1e-4);
    EXPECT_NEAR(linear.texel(0, 0)[c], 1, 1e-4);
  }
}

TEST_F(RendererTest, EnvironmentIsNotMirrored) {
  // Seen from +Z looking along −Z: +X lies on the right, +Y above.
  formats::Image image(256, 128, {"R", "G", "B"});
  addPatch(image, {0.3, 0, -1}, {1, 0, 0});
  addPatch(image, {0, 0.3, -1}, {0, 1, 0});
  addPatch(image, {-0.3, 0, -1}, {0, 0, 1});
  Renderer renderer(emptyPack(), transport::lightingFromImage(image, 2, "patches"));
  renderer.draw({.width_px = 101, .height_px = 101, .yaw_deg = 0, .pitch_deg = 0, .field_of_view_deg = 90});
  const auto linear = renderer.target().linearImage();
  EXPECT_NEAR(linear.texel(65, 50)[0], 1, 1e-3) << "+X";
  EXPECT_NEAR(linear.texel(50, 35)[1], 1, 1e-3) << "+Y";
  EXPECT_NEAR(linear.texel(35, 50)[2], 1, 1e-3) << "-X";
  EXPECT_NEAR(linear.texel(50, 65)[1], 0, 1e-3) << "-Y";
}

TEST_F(RendererTest, EnvironmentTurnsWithTheLight) {
  formats::Image image(256, 128, {"R", "G", "B"});
  addPatch(image, {0, 0, 1}, {1, 1, 1});
  Renderer renderer(emptyPack(), transport::lightingFromImage(image, 2, "patch"));
  // The light's yaw takes +Z to +X, which a camera that stands at −X looks at.
  renderer.draw({.width_px = 31, .height_px = 31, .yaw_deg = -90, .pitch_deg = 0, .light_yaw_deg = 90});
  EXPECT_NEAR(renderer.target().linearImage().texel(15, 15)[0], 1, 1e-3);
  renderer.draw({.width_px = 31, .height_px = 31, .yaw_deg = -90, .pitch_deg = 0, .light_yaw_deg = -90});
  EXPECT_NEAR(renderer.target().linearImage().texel(15, 15)[0], 0, 1e-3);
}

TEST_F(RendererTest, BackdropIsLookUpLatLongInEveryDirection) {
  formats::Image image(64, 32, {"R", "G", "B"});
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c)
        image.texel(x, y)[c] = static_cast<float>((x * 37 + y * 101 + c * 59) % 64) / 64;
  Renderer renderer(emptyPack(), transport::lightingFromImage(image, 2, "noise"));
  // Six views that cover the sphere, its poles and the seam at −Z among them.
  for (const auto& [yaw, pitch] :
       {std::pair{0.0, 0.0}, {90.0, 0.0}, {180.0, 0.0}, {270.0, 0.0}, {30.0, 89.0}, {30.0, -89.0}}) {
    const formats::FrameSettings settings{.width_px = 64,
                                          .height_px = 64,
                                          .supersampling = 1,
                                          .yaw_deg = yaw,
                                          .pitch_deg = pitch,
                                          .field_of_view_deg = 100};
    renderer.draw(settings);
    const auto linear = renderer.target().linearImage();
    const auto camera = transport::frameCamera(settings, renderer.bounds());
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x) {
        const auto expected =
            transport::lookUpLatLong(image, camera.directionThrough(x + 0.5, y + 0.5, 64, 64));
        for (std::size_t c = 0; c < 3; ++c)
          ASSERT_NEAR(linear.texel(x, y)[c], expected[c], 1e-4)
              << yaw << ' ' << pitch << ": " << x << ' ' << y;
      }
  }
}

TEST_F(RendererTest, LightFromTheRightLightsTheRight) {
  formats::Image image(64, 32, {"R", "G", "B"});
  addPatch(image, Vec3::UnitX(), {100, 100, 100});
  Renderer renderer(spherePack(4, 32), transport::lightingFromImage(image, 4, "sun"));
  formats::FrameSettings settings{.width_px = 101,
                                  .height_px = 101,
                                  .yaw_deg = 0,
                                  .pitch_deg = 0,
                                  .background = formats::Background::kBlack};
  renderer.draw(settings);
  auto linear = renderer.target().linearImage();
  EXPECT_GT(linear.texel(85, 50)[0], 4 * std::abs(linear.texel(15, 50)[0]));
  // A quarter turn of the light about +Y takes it from +X to −Z, behind the sphere; another one to −X.
  settings.light_yaw_deg = 180;
  renderer.draw(settings);
  linear = renderer.target().linearImage();
  EXPECT_GT(linear.texel(15, 50)[0], 4 * std::abs(linear.texel(85, 50)[0]));
}

TEST_F(RendererTest, TurnedObjectUnderUniformLightShowsItsOtherSide) {
  // Vertex colours tell the sides apart: red at +X, green at −X.
  formats::Pack pack = spherePack(3, 32);
  for (const auto& normal : pack.mesh.normals)
    pack.colors.push_back({normal[0] > 0 ? 1.0f : 0.0f, normal[0] > 0 ? 0.0f : 1.0f, 0});
  Renderer renderer(pack, uniformLighting(3, 1));
  formats::FrameSettings settings{.width_px = 33, .height_px = 33, .yaw_deg = 90, .pitch_deg = 0};
  renderer.draw(settings);
  EXPECT_NEAR(renderer.target().linearImage().texel(16, 16)[0], 1, 1e-3);
  settings.object_yaw_deg = 180;
  renderer.draw(settings);
  EXPECT_NEAR(renderer.target().linearImage().texel(16, 16)[0], 0, 1e-3);
  EXPECT_NEAR(renderer.target().linearImage().texel(16, 16)[1], 1, 1e-3);
}

TEST_F(RendererTest, LightStaysWhenTheObjectTurns) {
  // A sphere looks the same however it is turned.
  formats::Image image(64, 32, {"R", "G", "B"});
  addPatch(image, {1, 0.4, 0.3}, {100, 60, 30});
  Renderer renderer(spherePack(4, 64), transport::lightingFromImage(image, 4, "sun"));
  formats::FrameSettings settings{
      .width_px = 48, .height_px = 48, .background = formats::Background::kTransparent};
  renderer.draw(settings);
  const auto before = renderer.target().linearImage();
  settings.object_yaw_deg = 50;
  settings.object_pitch_deg = -70;
  renderer.draw(settings);
  const auto after = renderer.target().linearImage();
  for (const int x : {12, 20, 24, 30, 36})
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(after.texel(x, 24)[c], before.texel(x, 24)[c], 0.01 * before.texel(30, 24)[0] + 1e-3) << x;
}

TEST_F(RendererTest, MeshFarFromTheOriginLooksTheSame) {
  formats::Pack near_pack = spherePack(3, 32), far_pack = near_pack;
  // Steps of 1/8 are exact at an offset of 1e6, so both meshes have the same shape.
  for (std::size_t v = 0; v < near_pack.mesh.vertexCount(); ++v)
    for (std::size_t k = 0; k < 3; ++k) {
      float& value = near_pack.mesh.positions[v][k];
      value = std::round(value * 64) / 8;
      far_pack.mesh.positions[v][k] = value + 1e6f;
    }
  const formats::FrameSettings settings{
      .width_px = 64, .height_px = 48, .background = formats::Background::kTransparent};
  Renderer near_renderer(near_pack, transport::defaultLighting(3)),
      far_renderer(far_pack, transport::defaultLighting(3));
  near_renderer.draw(settings);
  far_renderer.draw(settings);
  const auto near_values = near_renderer.target().linearImage().values;
  const auto far_values = far_renderer.target().linearImage().values;
  std::size_t covered = 0;
  for (std::size_t i = 0; i < near_values.size(); ++i) {
    EXPECT_NEAR(near_values[i], far_values[i], 1e-3);
    if (near_values[i] > 0.1f) ++covered;
  }
  EXPECT_GT(covered, near_values.size() / 4);
}

TEST_F(RendererTest, NoVertexShowsTheBackdrop) {
  formats::Pack pack;
  pack.sh().order = 2;
  Renderer renderer(pack, uniformLighting(2, 0.5f));
  renderer.draw({.width_px = 8, .height_px = 8});
  for (int x = 0; x < 8; ++x) EXPECT_NEAR(renderer.target().linearImage().texel(x, x)[0], 0.5, 1e-6);
}

TEST_F(RendererTest, OnePixelAndEverySizeAfterIt) {
  Renderer renderer(spherePack(2, 16), uniformLighting(2, 1));
  for (const int size : {1, 300, 1, 17}) {
    renderer.draw({.width_px = size, .height_px = size, .supersampling = 4});
    const auto linear = renderer.target().linearImage();
    ASSERT_EQ(linear.width, size);
    EXPECT_NEAR(linear.texel(size / 2, size / 2)[0], 1, 1e-4);
  }
}

}  // namespace
}  // namespace bakelight::player
