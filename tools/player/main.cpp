// player: shows a pack under its lights, in a window or as one picture.
#include <spdlog/spdlog.h>

#include <utility>

#include "formats/light_rig_file.h"
#include "formats/pack.h"
#include "tools/player/controls.h"
#include "tools/player/headless.h"
#include "tools/player/options.h"
#include "tools/player/picture_file.h"
#include "tools/player/renderer.h"
#include "tools/player/window.h"
#include "tools/stage/stage.h"
#include "transport/bi_scale_shading.h"
#include "transport/windowing.h"

using namespace bakelight;

int main(int argc, char** argv) {
  player::Options options;
  stage::Tool tool("player",
                   std::string("Plays a pack back in real time. In the window: ") + player::kControlsHelp);
  player::declareOptions(tool, options);

  return tool.run(argc, argv, [&](stage::Run& run) {
    const bool headless = !options.image_path.empty();
    const auto encoding =
        headless ? player::encodingFor(options.image_path) : player::PictureEncoding::kDisplay;
    const formats::FrameSettings settings = options.settings;
    formats::Pack pack = formats::readPack(options.pack_path);
    if (options.effects != transport::BiScaleEffects::kAll) {
      if (!transport::BiScaleShading::shades(pack))
        throw badInput({options.pack_path.string(), "", "/effects"},
                       "it has no meso-structure to compare without",
                       "a pack with a radiance transfer texture, or effects all");
      pack = transport::withEffects(std::move(pack), options.effects);
    }
    if (options.branches != transport::TranslucentResponse::Branches::kBoth) {
      if (!transport::TranslucentShading::shades(pack))
        throw badInput({options.pack_path.string(), "", "/branches"},
                       "it is not translucent, so it has no branches",
                       "a pack of a translucent object, or branches both");
      pack = transport::withBranches(std::move(pack), options.branches);
    }
    formats::LightRig rig =
        formats::readLights(options.environment_path, options.lights_path, options.windowing);
    for (const std::string& note : formats::notesOn(rig)) run.warn(note);
    transport::requirePunctualTaken(rig, player::techniqueFor(pack).needs(pack),
                                    options.lights_path.string());
    transport::Lighting lighting =
        transport::lightingFor(std::move(rig), player::lightOrder(pack), options.lights_path.string());
    const std::string ringing =
        transport::ringingWarning(transport::minimumOverMean(lighting.distant), lighting.window);
    if (!ringing.empty()) run.warn(ringing);
    lighting.cube_resolution = options.cube_resolution;
    const player::SurroundingsOptions surroundings = player::surroundingsFor(options, pack);
    if (!headless) return player::playInWindow(pack, lighting, settings, surroundings);

    const player::HeadlessPicture picture =
        player::renderHeadless(pack, lighting, settings, encoding, surroundings);
    spdlog::info("{}", picture.gl_renderer);
    player::writePicture(options.image_path, picture.image, encoding);
    player::reportStats(run, pack, lighting, picture);
  });
}
