#include "tools/player/options.h"

namespace bakelight::player {

void declareOptions(stage::Tool& tool, Options& options) {
  FrameSettings& settings = options.settings;
  tool.input("pack", "pack", options.pack_path, "the pack to play")
      .input("environment", "image", options.environment_path,
             "lat-long HDR light; without it and lights: a soft key light", false)
      .input("lights", "light_rig", options.lights_path, "light rig: distant lights and emitters; adds up",
             false)
      .output("image", "image", options.image_path,
              "write one frame (.png, or .exr with linear radiance), no window", false)
      .parameter("width", settings.width_px, {1, 16384}, "px", "width of window or picture")
      .parameter("height", settings.height_px, {1, 16384}, "px", "height of window or picture")
      .parameter("supersampling", settings.supersampling, {1, 4}, "", "subsamples of a pixel along each axis")
      .parameter("yaw_deg", settings.yaw_deg, {-360, 360}, "deg", "camera angle around +Y, 0 stands at +Z")
      .parameter("pitch_deg", settings.pitch_deg, {-89, 89}, "deg", "camera angle above the horizon")
      .parameter("distance", settings.distance, {0.2, 20}, "", "camera distance, 1 just frames the object")
      .parameter("field_of_view_deg", settings.field_of_view_deg, {1, 120}, "deg", "vertical field of view")
      .parameter("light_yaw_deg", settings.light_yaw_deg, {-360, 360}, "deg",
                 "turns the distant light about +Y")
      .parameter("light_pitch_deg", settings.light_pitch_deg, {-360, 360}, "deg", "then turns it about +X")
      .parameter("object_yaw_deg", settings.object_yaw_deg, {-360, 360}, "deg",
                 "turns the object about +Y, under lights that stay")
      .parameter("object_pitch_deg", settings.object_pitch_deg, {-360, 360}, "deg", "then turns it about +X")
      .parameter("time_s", settings.time_s, {0, 1e6}, "s", "where moving emitters are, or start in a window")
      .parameter(
          "windowing", options.windowing, {-1, 1e9}, "",
          "window against ringing of distant light: 0 the rig's own, -1 just enough, else its strength")
      .parameter("cube_resolution", options.cube_resolution, {4, 1024}, "px",
                 "edge of the cube map that emitters are drawn into")
      .parameter("auto_exposure", settings.auto_exposure, "bring the lights' mean radiance to a middle value")
      .parameter("exposure_ev", settings.exposure_ev, {-32, 32}, "EV",
                 "stops brighter than that, or than factor 1")
      .parameter("background", options.background, backgroundNames(), "what is seen past the object");
}

FrameSettings settingsOf(const Options& options) {
  FrameSettings settings = options.settings;
  settings.background = backgroundNamed(options.background);
  return settings;
}

void reportStats(stage::Run& run, const formats::Pack& pack, const Lighting& lighting,
                 const HeadlessPicture& picture) {
  const formats::RadianceTransfer& transfer = pack.transfer;
  run.stat("vertices", pack.mesh.vertexCount());
  run.stat("triangles", pack.mesh.triangleCount());
  run.stat("order", transfer.order);
  run.stat("precision", formats::nameOf(transfer.vectors.precision));
  run.stat("storage", formats::nameOf(transfer.storage));
  if (transfer.storage != formats::MatrixStorage::kNone) {
    run.stat("row_order", transfer.row_order);
    run.stat("matrix_precision", formats::nameOf(transfer.matrices.precision));
    run.stat("material", formats::nameOf(transfer.material.model));
  }
  run.stat("exposure", picture.exposure);
  run.stat("window", lighting.window);
  run.stat("moved_energy", lighting.moved_energy);
  run.stat("gpu_bytes", picture.gpu_bytes);
  run.stat("light_change_ms", picture.light_change_ms);
  if (picture.cube_ms) run.stat("cube_ms", *picture.cube_ms);
  run.stat("frame_ms", picture.frame_ms);
}

}  // namespace bakelight::player
