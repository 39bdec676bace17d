#include "tools/rtt/btf_output.h"

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

#include "formats/error.h"
#include "tools/rtt/baking.h"
#include "transport/btf_factorization.h"

namespace bakelight::rtt {

void declare(stage::Tool& tool, BtfOutput& output) {
  tool.output("btf", "btf", output.path,
              "A .btf file of the one material with such a patch: for light from each cell of a grid", false)
      .output("btfs", "tensors", output.tables,
              "Likewise, of all materials with a patch, as tables (safetensors)", false)
      .input("measured_btfs", "tensors", output.measured,
             "For these: what btf made of the materials whose patch is a measured BTF", false)
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

namespace {

using Clock = std::chrono::steady_clock;
double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// As a `.btf`; read again.
void writeBtf(const BtfOutput& output, const formats::Btf& btf, formats::Json& json) {
  const auto writing = Clock::now();
  if (output.layout == formats::BtfWrittenLayout::kRaw) {
    formats::writeRawBtf(output.path, btf);
  } else {
    const transport::BtfFactorization factorization = transport::factorize(btf, output.model, output.rank);
    formats::writeFactorizedBtf(output.path, btf.info(), output.model, factorization.channels,
                                output.precision);
    for (const formats::BtfFactors& factors : factorization.channels) json["ranks"].push_back(factors.rank);
    json["channel_errors"] = factorization.relative_errors;
  }
  json["written_bytes"] = std::filesystem::file_size(output.path);
  json["written_error"] = transport::relativeError(*formats::openBtf(output.path), btf);
  json["writing_s"] = secondsSince(writing);
}

formats::BtfTableShape shapeOf(const BtfSource& source, const BtfOutput& output, const Options& options) {
  if (source.table)
    return {source.material, source.table->views, source.table->lights, source.table->width,
            source.table->height};
  return {source.material, options.views, output.options.lights, options.resolution,
          texelsDown(options, source.geometry->aspect)};
}

}  // namespace

formats::Json makeAndWrite(const BtfOutput& output, const std::vector<BtfSource>& sources,
                           const Options& options, stage::Run& run) {
  const auto views = static_cast<std::size_t>(options.views) * options.views;
  stage::Progress progress = run.progress("btf", sources.size() * views, "views");
  std::optional<formats::BtfTableWriter> tables;
  if (!output.tables.empty()) {
    std::vector<formats::BtfTableShape> shapes;
    for (const BtfSource& source : sources) shapes.push_back(shapeOf(source, output, options));
    tables.emplace(output.tables, shapes);
  }
  formats::Json all = formats::Json::array();
  for (const BtfSource& source : sources) {
    if (source.table) {
      if (tables) {
        formats::BtfTable table = *source.table;
        table.material = source.material;
        tables->append(table);
      }
      progress.advance(views);
      all.push_back({{"material", source.material}, {"file", source.table->file}});
      continue;
    }
    const auto rendering = Clock::now();
    const DirectionalBtf made =
        makeBtf(*source.geometry, options, output.options, source.material, [&] { progress.advance(1); });
    const formats::BtfInfo& info = made.btf->info();
    all.push_back({{"material", source.material},
                   {"width", info.width},
                   {"height", info.height},
                   {"views", info.views.size()},
                   {"lights", info.lights.size()},
                   {"expanded_bytes", btfBytes(options, output.options, source.geometry->aspect)},
                   {"rays", made.figures.rays},
                   {"mean_albedo", made.figures.mean_albedo},
                   {"rendering_s", secondsSince(rendering)}});
    if (tables) tables->append(source.material, made.values());
    if (!output.path.empty()) writeBtf(output, *made.btf, all.back());
  }
  if (tables) tables->finish();
  return all;
}

}  // namespace bakelight::rtt
