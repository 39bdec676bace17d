#include "tools/reference/reference.h"

#include <fmt/format.h>

#include <algorithm>

#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "transport/frame.h"
#include "transport/lighting.h"

namespace bakelight::reference {
namespace {

using transport::BoundingSphere;

constexpr double kTolerableLoss = 1e-3;  // of walks through media

std::string text(double number) {
  return fmt::format("{:.17g}", number);
}

std::string text(const Vec3& v) {
  return text(v.x()) + " " + text(v.y()) + " " + text(v.z());
}

// As the player draws it.
transport::Backdrop backdropOf(const formats::LightRig& rig, const formats::FrameSettings& frame) {
  switch (frame.background) {
    case formats::Background::kTransparent:
      return [](const Vec3&) -> formats::Float4 { return {0, 0, 0, 0}; };
    case formats::Background::kBlack:
      return [](const Vec3&) -> formats::Float4 { return {0, 0, 0, 1}; };
    case formats::Background::kEnvironment:
      break;
  }
  transport::Lighting lighting = transport::lightingFor(rig, 1, "lights");
  return [image = std::move(lighting.backdrop),
          light_from_world = Eigen::Matrix3d(transport::worldFromLight(frame).transpose())](
             const Vec3& direction) -> formats::Float4 {
    const transport::Float3 radiance = transport::lookUpLatLong(image, light_from_world * direction);
    return {radiance[0], radiance[1], radiance[2], 1};
  };
}

std::map<std::string, std::string> metadataOf(const Options& options, const Surface& surface,
                                              const transport::OrbitCamera& camera,
                                              const BoundingSphere& bounds, const RoundsReport& report) {
  using formats::wordFor;
  return {{"bakelight:frame", formats::toJson(options.frame).dump()},
          {"bakelight:eye", text(camera.eye())},
          {"bakelight:target", text(camera.target)},
          {"bakelight:fov_deg", text(camera.field_of_view_deg)},
          {"bakelight:bounds", text(bounds.center) + " " + text(bounds.radius)},
          {"bakelight:transport", wordFor(kTransports, options.paths.transport)},
          {"bakelight:reflection", wordFor(kReflectionModels, surface.model)},
          {"bakelight:translucency", wordFor(kTranslucencies, surface.translucency)},
          {"bakelight:bounces", std::to_string(options.paths.bounces)},
          {"bakelight:integrator", wordFor(kIntegrators, options.paths.integrator)},
          {"bakelight:at", wordFor(kAts, options.at)},
          {"bakelight:seed", std::to_string(options.seed)},
          {"bakelight:samples_per_pixel", std::to_string(report.samples)},
          {"bakelight:relative_error", text(report.relative_error)}};
}

}  // namespace

Reference makeReference(const Surface& surface, const formats::LightRig& rig, const Options& options,
                        const std::optional<BoundingSphere>& bounds, stage::ProgressStyle progress) {
  const BoundingSphere framed = bounds.value_or(transport::boundingSphere(surface.mesh));
  const Scene scene(surface, rig, options.frame, framed);
  const PathTracer tracer(scene, options.paths);
  View view{transport::frameCamera(options.frame, framed), options.frame.width_px, options.frame.height_px,
            backdropOf(rig, options.frame)};
  if (options.ground) {
    if (options.at != At::kPixels)
      throw badInput({"", "", "/ground"}, "a ground has no vertices to trace at", "at pixels",
                     "leave out ground, or at");
    view.ground.emplace(*options.ground, surface.mesh, framed, transport::worldFromObject(options.frame));
  }
  const auto trace = options.at == At::kPixels     ? tracePixels
                     : options.at == At::kVertices ? traceVertices
                                                   : traceTriangles;
  Reference reference{
      trace(scene, tracer, view, options.effort, static_cast<std::uint64_t>(options.seed), progress), {}};
  reference.metadata = metadataOf(options, surface, view.camera, framed, reference.picture.report);
  return reference;
}

BoundingSphere boundsFromMetadata(const std::map<std::string, std::string>& metadata,
                                  const std::string& file) {
  const auto found = metadata.find("bakelight:bounds");
  std::istringstream numbers(found == metadata.end() ? "" : found->second);
  numbers.imbue(std::locale::classic());
  BoundingSphere bounds;
  if (!(numbers >> bounds.center.x() >> bounds.center.y() >> bounds.center.z() >> bounds.radius) ||
      !(bounds.radius >= 0))
    throw badInput({file, "attribute bakelight:bounds", ""}, "it is missing, or not four numbers",
                   "a picture that this tool has made");
  return bounds;
}

void reportStats(stage::Run& run, const Picture& picture, const Options& options) {
  const RoundsReport& report = picture.report;
  run.stat("relative_error", report.relative_error);
  run.stat("converged", report.converged);
  run.stat("samples_per_pixel", report.samples);
  run.stat("rounds", report.rounds);
  run.stat("object_pixels", picture.object_pixels);
  const TraceCounts& counts = report.counts;
  run.stat("rays", counts.rays);
  run.stat("rays_per_s", report.seconds > 0 ? static_cast<double>(counts.rays) / report.seconds : 0.0);
  run.stat("trace_s", report.seconds);
  run.stat("walks", counts.walks);
  run.stat("open_walks", counts.open_walks);
  run.stat("cut_walks", counts.cut_walks);
  const auto warnOfLost = [&](std::uint64_t walks, const std::string& what) {
    const double lost =
        static_cast<double>(walks) / static_cast<double>(std::max<std::uint64_t>(counts.walks, 1));
    if (lost > kTolerableLoss)
      run.warn(fmt::format("{:.2g} % of the walks through media {}, and their light is missing", 100 * lost,
                           what));
  };
  warnOfLost(counts.open_walks, "left the mesh through a hole: a medium needs a closed mesh");
  warnOfLost(counts.cut_walks,
             fmt::format("were cut off after {} events: little is absorbed, and paths are short for the mesh",
                         RandomWalk::kMostEvents));
  if (picture.object_pixels == 0) run.warn("no pixel sees the object");
  if (!report.converged)
    run.warn("relative error " + text(report.relative_error) + " after " + std::to_string(report.samples) +
             " samples a pixel, not " + text(options.effort.relative_error) + "; raise samples");
}

}  // namespace bakelight::reference
