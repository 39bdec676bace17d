#include "tools/rtt/btf_output.h"

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

#include "formats/error.h"
#include "transport/btf_factorization.h"

namespace bakelight::rtt {

void declare(stage::Tool& tool, BtfOutput& output) {
  tool.output("btf", "btf", output.path,
              "A .btf file of the one material with such a patch: for light from each cell of a grid", false)
      .parameter("btf_lights", output.options.lights, {1, 32}, "",
                 "A side of the BTF's grid of lights over the hemisphere")
      .parameter("btf_light_samples", output.options.light_samples, {1, 16}, "",
                 "A side, directions in each cell of that grid, of which the BTF has the mean")
      .parameter("btf_layout", output.layout, formats::kBtfWrittenLayouts, "Of the .btf")
      .parameter("btf_color_model", output.model, formats::kBtfWrittenModels, "Of a factorized .btf")
      .parameter("btf_rank", output.rank, {1, 1024}, "", "Products a channel of a factorized .btf at most")
      .parameter("btf_precision", output.precision, formats::kBtfPrecisions, "Of a factorized .btf");
}

void requireRoom(const BtfOutput& output, const patch::PatchGeometry& geometry, const Options& options,
                 stage::Run& run) {
  constexpr double kMost = 4.3e9, kMany = 1e9, kMostLight = 1.1e9;
  const auto gigabytes = [](double bytes) { return std::to_string(bytes / 1e9) + " GB"; };
  const double bytes = btfBytes(options, output.options, geometry.aspect);
  if (bytes > kMost)
    throw Error(ExitStatus::kUsage, {"", "--btf", ""}, "a BTF of that size takes " + gigabytes(bytes),
                gigabytes(kMost) + " of memory at most", "lessen resolution, views or btf_lights");
  const double light_bytes = lightBytes(geometry, options, output.options);
  if (light_bytes > kMostLight)
    throw Error(ExitStatus::kUsage, {"", "--btf", ""},
                "light from " + std::to_string(output.options.lights * output.options.lights) +
                    " cells on so fine a surface takes " + gigabytes(light_bytes),
                gigabytes(kMostLight) + " at most", "lessen elements or btf_lights");
  if (bytes > kMany) run.warn("the BTF takes " + gigabytes(bytes) + " of memory until it is written");
}

formats::Json makeAndWrite(const BtfOutput& output, const patch::PatchGeometry& geometry,
                           const Options& options, stage::Run& run) {
  using Clock = std::chrono::steady_clock;
  const auto seconds_since = [](Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  stage::Progress progress =
      run.progress("btf", static_cast<std::size_t>(options.views) * options.views, "views");
  const auto rendering = Clock::now();
  const DirectionalBtf made =
      makeBtf(geometry, options, output.options, output.path.string(), [&] { progress.advance(1); });
  const formats::BtfInfo& info = made.btf->info();
  formats::Json json = {{"width", info.width},
                        {"height", info.height},
                        {"views", info.views.size()},
                        {"lights", info.lights.size()},
                        {"expanded_bytes", btfBytes(options, output.options, geometry.aspect)},
                        {"rays", made.figures.rays},
                        {"mean_albedo", made.figures.mean_albedo},
                        {"rendering_s", seconds_since(rendering)}};
  const auto writing = Clock::now();
  if (output.layout == formats::BtfWrittenLayout::kRaw) {
    formats::writeRawBtf(output.path, *made.btf);
  } else {
    const transport::BtfFactorization factorization =
        transport::factorize(*made.btf, output.model, output.rank);
    formats::writeFactorizedBtf(output.path, info, output.model, factorization.channels, output.precision);
    for (const formats::BtfFactors& factors : factorization.channels) json["ranks"].push_back(factors.rank);
    json["channel_errors"] = factorization.relative_errors;
  }
  json["written_bytes"] = std::filesystem::file_size(output.path);
  json["written_error"] = transport::relativeError(*formats::openBtf(output.path), *made.btf);
  json["writing_s"] = seconds_since(writing);
  return json;
}

}  // namespace bakelight::rtt
