#include "tools/player/options.h"

#include "tools/stage/frame_options.h"

namespace bakelight::player {

void declareOptions(stage::Tool& tool, Options& options) {
  formats::FrameSettings& settings = options.settings;
  tool.input("pack", "pack", options.pack_path, "the pack to play")
      .input("environment", "image", options.environment_path,
             "lat-long HDR light; without it and lights: a soft key light", false)
      .input("lights", "light_rig", options.lights_path, "light rig: distant lights and emitters; adds up",
             false)
      .output("image", "image", options.image_path,
              "write one frame (.png, or .exr with linear radiance), no window", false);
  stage::declareFrame(tool, settings, options.background);
  tool.parameter("windowing", options.windowing, {{"rig", std::nullopt}, {"auto", -1}, {"none", 0}},
                 {-1, 1e9},
                 "strength of the window against ringing of distant light; rig: as the rig says, auto or -1: "
                 "just enough, none or 0: no window")
      .parameter("cube_resolution", options.cube_resolution, {4, 1024}, "px",
                 "edge of the cube map that emitters are drawn into")
      .parameter("auto_exposure", settings.auto_exposure, "bring the lights' mean radiance to a middle value")
      .parameter("exposure_ev", settings.exposure_ev, {-32, 32}, "EV",
                 "stops brighter than that, or than factor 1");
}

void reportStats(stage::Run& run, const formats::Pack& pack, const transport::Lighting& lighting,
                 const HeadlessPicture& picture) {
  const formats::ShTransfer& transfer = pack.sh();
  run.stat("vertices", pack.mesh.vertexCount());
  run.stat("triangles", pack.mesh.triangleCount());
  run.stat("order", transfer.order);
  run.stat("precision", formats::nameOf(transfer.vectors.precision));
  run.stat("storage", transfer.glossy ? transfer.glossy->operatorName() : "none");
  if (transfer.glossy) {
    run.stat("row_order", transfer.glossy->output_order);
    run.stat("matrix_precision", formats::nameOf(transfer.glossy->vertexTable().precision));
  }
  formats::Json reflections = formats::Json::array();
  for (const formats::Appearance& appearance : pack.appearances)
    reflections.push_back(appearance.reflection.kind());
  run.stat("reflection", std::move(reflections));
  run.stat("exposure", picture.exposure);
  run.stat("window", lighting.window);
  run.stat("moved_energy", lighting.moved_energy);
  run.stat("gpu_bytes", picture.gpu_bytes);
  const auto times = [&](const std::string& name, const Times_ms& of) {
    run.stat(name, of.median);
    run.stat(name + "_low", of.low);
    run.stat(name + "_high", of.high);
  };
  times("light_change_ms", picture.light_change_ms);
  if (picture.cube_ms) times("cube_ms", *picture.cube_ms);
  times("frame_ms", picture.frame_ms);
}

}  // namespace bakelight::player
