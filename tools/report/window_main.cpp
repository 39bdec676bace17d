// window: which window against ringing a pack's light needs, by the error that it saves.
#include <filesystem>
#include <utility>

#include "formats/error.h"
#include "tools/report/evaluation.h"
#include "tools/report/window.h"
#include "tools/stage/frame_options.h"
#include "tools/stage/stage.h"
#include "transport/windowing.h"

using namespace bakelight;

int main(int argc, char** argv) {
  report::PlanView view;
  view.name = view.camera = "frame";
  view.light = "light";
  view.windowing = 0;
  view.windows_measured = true;
  report::PlanVariant variant;
  variant.name = "pack";

  stage::Tool tool(
      "window",
      "Finds the window against ringing with which a pack under its light errs least in what is shown.");
  tool.input("pack", "pack", variant.pack.path, "the pack")
      .input("reference", "image", view.reference.path,
             "a picture of it by `reference`, on transparent background, of the same frame and light")
      .input("environment", "image", view.environment_path, "lat-long HDR light, as the player's", false)
      .input("lights", "light_rig", view.lights_path, "light rig, as the player's; adds up", false);
  stage::declareFrame(tool, view.frame);
  tool.parameter("ground_albedo", view.ground_albedo, {0, 1}, "",
                 "Of a pack that stands on a ground: what that reflects, red, green, blue");
  tool.executionPath(transport::RayScene::executionPath);

  return tool.run(argc, argv, [&](stage::Run& run) {
    report::Plan plan;
    plan.views.push_back(view);
    plan.variants.push_back(variant);
    const report::Sources sources = report::fileSources();
    report::Evaluator evaluator(plan, sources);
    const std::optional<report::WindowChoice> choice = evaluator.windowOf(variant.pack, 0);
    const report::WindowChoice chosen = choice.value_or(report::WindowChoice());
    if (choice && chosen.error.pixels == 0)
      run.warn(
          "no pixel of the picture sees the object wholly, so nothing was compared, and no window is set: "
          "more pixels, or a nearer camera, would tell");
    run.stat("pixels", chosen.error.pixels);
    run.stat("lambda", chosen.lambda);
    run.stat("error", chosen.error.displayed);
    run.stat("error_without", chosen.without.displayed);
    run.stat("error_saved", chosen.without.displayed - chosen.error.displayed);
    run.stat("rel_rmse", chosen.error.radiance);
    run.stat("rel_rmse_without", chosen.without.radiance);
    run.stat("noise", report::relativeNoise(evaluator.truth()[0]));
    run.stat("needed", choice.has_value());
  });
}
