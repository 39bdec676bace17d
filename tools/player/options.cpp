#include "tools/player/options.h"

#include <spdlog/spdlog.h>

#include <initializer_list>

#include "formats/mesh_ply.h"
#include "formats/neighborhood.h"
#include "tools/player/techniques/technique.h"
#include "tools/stage/frame_options.h"

namespace bakelight::player {

void declareOptions(stage::Tool& tool, Options& options) {
  formats::FrameSettings& settings = options.settings;
  tool.input("pack", "pack", options.pack_path, "the pack to play")
      .input("environment", "image", options.environment_path,
             "lat-long HDR light; without it and lights: a soft key light", false)
      .input("lights", "light_rig", options.lights_path, "light rig: distant lights and emitters; adds up",
             false)
      .input("receiver_mesh", "mesh", options.receiver_path,
             "With receiver mesh: PLY mesh with normals, as simplify writes it", false)
      .output("image", "image", options.image_path,
              "write one frame (.png, or .exr with linear radiance), no window", false);
  stage::declareFrame(tool, settings);
  tool.parameter("windowing", options.windowing, {{"rig", std::nullopt}, {"auto", -1}, {"none", 0}},
                 {-1, 1e9},
                 "strength of the window against ringing of distant light; rig: as the rig says, auto or -1: "
                 "just enough, none or 0: no window")
      .parameter("cube_resolution", options.cube_resolution, {4, 1024}, "px",
                 "edge of the cube map that emitters are drawn into")
      .parameter("effects", options.effects, transport::kBiScaleEffects,
                 "Of a pack with meso-structure, to compare: without the object's own shadows, without "
                 "masking, the mean "
                 "over views, or the object's shadows alone")
      .parameter("branches", options.branches, transport::kTranslucentBranches,
                 "Of a translucent object, to compare: what comes from near by, by kernels of texels, what "
                 "comes from "
                 "farther off, by factors between vertices, or both")
      .parameter("ground", options.surroundings.ground, kShownGrounds,
                 "The plane that the object stands on, in its shadow; auto: of packs that have one, unless "
                 "the background is transparent")
      .parameter("ground_albedo", options.surroundings.ground_albedo, {0, 1}, "",
                 "what it reflects, red, green, blue")
      .parameter("receiver", options.receiver, kShownReceivers,
                 "A diffuse body in the object's shadow; the pack needs a neighborhood with a volume")
      .parameter("receiver_position", options.receiver_options.position, {-20, 20}, "",
                 "its middle at time 0, from the object's, in radii of the object's bounding sphere")
      .parameter("receiver_radius", options.receiver_options.radius, {0.01, 10}, "", "its size, likewise")
      .parameter("receiver_albedo", options.receiver_options.albedo, {0, 1}, "",
                 "what it reflects, red, green, blue")
      .parameter("receiver_orbit_s", options.receiver_options.orbit_s, {0, 1e6}, "s",
                 "once around the object about +Y; 0: it stands still")
      .parameter("auto_exposure", settings.auto_exposure, "bring the lights' mean radiance to a middle value")
      .parameter("exposure_ev", settings.exposure_ev, {-32, 32}, "EV",
                 "stops brighter than that, or than factor 1");
}

namespace {

void reportTimes(stage::Run& run, const std::string& name, const Times_ms& times) {
  run.stat(name, times.median);
  run.stat(name + "_low", times.low);
  run.stat(name + "_high", times.high);
}

void reportTransfer(stage::Run& run, const formats::ShTransfer& transfer) {
  run.stat("order", transfer.order);
  run.stat("precision", formats::nameOf(transfer.vectors.precision));
  run.stat("storage", transfer.glossy ? transfer.glossy->operatorName() : "none");
  if (!transfer.glossy) return;
  run.stat("row_order", transfer.glossy->output_order);
  run.stat("matrix_precision", formats::nameOf(transfer.glossy->vertexTable().precision));
}

// Cost by pass as Lensch et al. 2002 have it, table 1.
void reportTranslucency(stage::Run& run, const formats::Translucency& translucency,
                        const formats::Json& passes) {
  const auto sum = [&](std::initializer_list<const char*> names) {
    double ms = 0;
    for (const char* name : names) ms += passes.value(name, 0.0);
    return ms;
  };
  const double illumination = sum({"illumination", "shadow map", "punctual light"}), local = sum({"filter"}),
               distribution = sum({"distribution"}), throughput = sum({"throughput"}),
               display = sum({"combination", "surface", "resolve"});
  const std::size_t factors = translucency.near.columns.count() + translucency.far.columns.count();
  const double total = illumination + local + distribution + throughput + display;
  run.stat("cost_by_pass", {{"vertices", translucency.knot_count},
                            {"factors", factors},
                            {"illumination_map_ms", illumination},
                            {"local_ms", local},
                            {"distribution_ms", distribution},
                            {"throughput_ms", throughput},
                            {"display_ms", display},
                            {"total_ms", total}});
  spdlog::info(
      "{} vertices, {} factors; ms: illumination map {:.3g}, local {:.3g}, distribution {:.3g}, throughput "
      "{:.3g}, "
      "display {:.3g}, total {:.3g}",
      translucency.knot_count, factors, illumination, local, distribution, throughput, display, total);
}

}  // namespace

SurroundingsOptions surroundingsFor(const Options& options, const formats::Pack& pack) {
  SurroundingsOptions result = options.surroundings;
  if (options.receiver == ShownReceiver::kNone) return result;
  const auto* neighborhood = pack.neighborhood ? pack.neighborhood->as<formats::Neighborhood>() : nullptr;
  if (neighborhood == nullptr || !neighborhood->volume)
    throw badInput({options.pack_path.string(), "", "/receiver"}, "it has no neighborhood with a volume",
                   "a pack with one", "bake it: neighborhood with volume_cells above 0");
  result.receiver = options.receiver_options;
  if (options.receiver == ShownReceiver::kSphere) {
    result.receiver->mesh = transport::unitSphere();
    return result;
  }
  if (options.receiver_path.empty())
    throw badInput({"", "", "/receiver"}, "it is a mesh, and none is given", "receiver_mesh",
                   "or receiver sphere");
  result.receiver->mesh = transport::unitSized(formats::readPly(options.receiver_path));
  if (result.receiver->mesh.normals.size() != result.receiver->mesh.vertexCount())
    throw badInput({options.receiver_path.string(), "", ""}, "it has no normals", "a mesh with normals",
                   "run the simplify tool on it, which computes them");
  return result;
}

void reportStats(stage::Run& run, const formats::Pack& pack, const transport::Lighting& lighting,
                 const HeadlessPicture& picture) {
  run.stat("vertices", pack.mesh.vertexCount());
  run.stat("triangles", pack.mesh.triangleCount());
  run.stat("technique", techniqueFor(pack).name);
  run.stat("transfer", pack.transfer.kind());
  if (const auto* transfer = pack.transfer.as<formats::ShTransfer>()) reportTransfer(run, *transfer);
  formats::Json reflections = formats::Json::array();
  for (const formats::Appearance& appearance : pack.appearances)
    reflections.push_back(appearance.reflection.kind());
  run.stat("reflection", std::move(reflections));
  run.stat("exposure", picture.exposure);
  run.stat("window", lighting.window);
  run.stat("moved_energy", lighting.moved_energy);
  run.stat("gpu_bytes", picture.gpu_bytes);
  reportTimes(run, "light_change_ms", picture.light_change.wall);
  reportTimes(run, "gpu_light_change_ms", picture.light_change.gpu);
  if (picture.cube) {
    reportTimes(run, "cube_ms", picture.cube->wall);
    reportTimes(run, "gpu_cube_ms", picture.cube->gpu);
  }
  reportTimes(run, "frame_ms", picture.frame.wall);
  reportTimes(run, "gpu_frame_ms", picture.frame.gpu);
  reportTimes(run, "read_back_ms", picture.read_back);
  formats::Json passes = formats::Json::object();
  for (const WorkTimes* times :
       {&picture.light_change, picture.cube ? &*picture.cube : nullptr, &picture.frame})
    if (times != nullptr)
      for (const auto& [name, pass_ms] : times->gpu_passes_ms) passes[name] = pass_ms;
  if (const auto* translucency = pack.appearances.front().reflection.as<formats::Translucency>())
    reportTranslucency(run, *translucency, passes);
  run.stat("gpu_pass_ms", std::move(passes));
}

}  // namespace bakelight::player
