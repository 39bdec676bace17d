// player: shows a pack under a light, in a window or as one picture.
#include <spdlog/spdlog.h>

#include "formats/pack.h"
#include "tools/player/controls.h"
#include "tools/player/headless.h"
#include "tools/player/picture_file.h"
#include "tools/player/window.h"
#include "tools/stage/stage.h"

using namespace bakelight;

int main(int argc, char** argv) {
  std::filesystem::path pack_path, environment_path, image_path;
  player::FrameSettings settings;
  std::string background = "environment";
  stage::Tool tool("player",
                   std::string("Plays a pack back in real time. In the window: ") + player::kControlsHelp);
  tool.input("pack", "pack", pack_path, "the pack to play")
      .input("environment", "image", environment_path, "lat-long HDR light; default: a soft key light", false)
      .output("image", "image", image_path, "write one frame (.png, or .exr with linear radiance), no window",
              false)
      .parameter("width", settings.width_px, {1, 16384}, "px", "width of window or picture")
      .parameter("height", settings.height_px, {1, 16384}, "px", "height of window or picture")
      .parameter("supersampling", settings.supersampling, {1, 4}, "", "subsamples of a pixel along each axis")
      .parameter("yaw_deg", settings.yaw_deg, {-360, 360}, "deg", "camera angle around +Y, 0 stands at +Z")
      .parameter("pitch_deg", settings.pitch_deg, {-89, 89}, "deg", "camera angle above the horizon")
      .parameter("distance", settings.distance, {0.2, 20}, "", "camera distance, 1 just frames the object")
      .parameter("field_of_view_deg", settings.field_of_view_deg, {1, 120}, "deg", "vertical field of view")
      .parameter("light_yaw_deg", settings.light_yaw_deg, {-360, 360}, "deg", "turns the light about +Y")
      .parameter("light_pitch_deg", settings.light_pitch_deg, {-360, 360}, "deg",
                 "then turns the light about +X")
      .parameter("auto_exposure", settings.auto_exposure, "bring the light's mean radiance to a middle value")
      .parameter("exposure_ev", settings.exposure_ev, {-32, 32}, "EV",
                 "stops brighter than that, or than factor 1")
      .parameter("background", background, player::backgroundNames(), "what is seen past the object");

  return tool.run(argc, argv, [&](stage::Run& run) {
    const bool headless = !image_path.empty();
    const auto encoding = headless ? player::encodingFor(image_path) : player::PictureEncoding::kDisplay;
    settings.background = player::backgroundNamed(background);
    const formats::Pack pack = formats::readPack(pack_path);
    const player::Environment environment =
        environment_path.empty() ? player::defaultEnvironment(pack.transfer.order)
                                 : player::readEnvironment(environment_path, pack.transfer.order);
    if (!headless) return player::playInWindow(pack, environment, settings);

    const player::HeadlessPicture picture = player::renderHeadless(pack, environment, settings, encoding);
    spdlog::info("{}", picture.gl_renderer);
    player::writePicture(image_path, picture.image, encoding);
    run.stat("vertices", pack.mesh.vertexCount());
    run.stat("triangles", pack.mesh.triangleCount());
    run.stat("order", pack.transfer.order);
    run.stat("exposure", picture.exposure);
    run.stat("light_change_ms", picture.light_change_ms);
    run.stat("frame_ms", picture.frame_ms);
  });
}
