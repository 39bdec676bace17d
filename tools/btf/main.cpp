// btf: a measured material as a radiance transfer texture, and as a `.btf` file.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/btf_pictures.h"
#include "formats/btf_table.h"
#include "formats/btf_writer.h"
#include "formats/error.h"
#include "formats/material.h"
#include "formats/radiance_transfer_texture.h"
#include "tools/btf/crop.h"
#include "tools/btf/projection.h"
#include "tools/btf/rewriting.h"
#include "tools/stage/stage.h"

using namespace bakelight;

namespace {

constexpr formats::Word<btf::Cosine> kCosines[] = {{"as_file_says", btf::Cosine::kAsFileSays},
                                                   {"inside", btf::Cosine::kInside},
                                                   {"outside", btf::Cosine::kOutside}};
constexpr formats::Word<formats::BtfPictureColors> kColors[] = {
    {"auto", formats::BtfPictureColors::kAutomatic}, {"xyz", formats::BtfPictureColors::kXyz}};
constexpr formats::Word<bool> kPrecisions[] = {{"half", false}, {"float", true}};

struct Options {
  std::filesystem::path measured, material_file, rtt, btfs, written;
  formats::BtfPictureOptions pictures;
  btf::ProjectionOptions projection;
  btf::GridLights grid;
  btf::RewritingOptions rewriting;
  btf::Crop crop;
  std::optional<double> scale;
  int resolution = 64;
  bool is_float = false;
  std::string material;
};

void declare(stage::Tool& tool, Options& options) {
  constexpr int kMostTexels = 65536;
  tool.input("measured", "btf", options.measured, "A .btf file, or a folder or zip of pictures", false)
      .input("material_file", "material", options.material_file,
             "Instead: each material's \"patch\" with a \"btf\" becomes a texture",
             {.required = false, .parts = {"patch"}})
      .input("table", "table", options.pictures.table,
             "Directions of pictures whose names do not state them (JSON, CSV)", false)
      .output("rtt", "rtt", options.rtt, "The radiance transfer texture (EXR)", false)
      .output("btfs", "tensors", options.btfs,
              "As tables (safetensors) in the directions that transfer in a pixel basis has: for light from "
              "each cell "
              "of a grid, by the grid of views",
              false)
      .output("written", "btf", options.written, "What is left of it as a .btf file", false)
      .parameter("views", options.projection.views, {1, 64}, "",
                 "A side of the texture's grid of views; 1 is the mean over views")
      .parameter("btf_lights", options.grid.lights, {1, 32}, "",
                 "A side of the tables' grid of lights over the hemisphere")
      .parameter("btf_light_samples", options.grid.light_samples, {1, 16}, "",
                 "A side, directions in each cell of that grid, of which tables have the mean")
      .parameter("order", options.projection.order, {1, 10}, "SH bands", "Of the texture")
      .parameter("resolution", options.resolution, {1, 8192}, "texels",
                 "Longer side at most: so many texels as it takes are averaged to one")
      .parameter("left", options.crop.left, {0, kMostTexels}, "texels", "Where the part that is kept begins")
      .parameter("top", options.crop.top, {0, kMostTexels}, "texels", "Where the part that is kept begins")
      .parameter("width", options.crop.width, {0, kMostTexels}, "texels", "Of the part that is kept; 0: all")
      .parameter("height", options.crop.height, {0, kMostTexels}, "texels",
                 "Of the part that is kept; 0: all")
      .parameter("scale", options.scale, stage::Tool::Words{{"auto", std::nullopt}}, {1e-9, 1e9},
                 "Times values it is reflectance per steradian; auto: 1 for .btf, 1/pi for pictures, in "
                 "which a white "
                 "diffuser then has the value 1")
      .parameter("cosine", options.projection.cosine, kCosines,
                 "Whether the cosine of light is in the values already; pictures say inside")
      .parameter("clockwise", options.projection.clockwise,
                 "Azimuths run from the pictures' right towards their bottom, not their top")
      .parameter("picture_colors", options.pictures.colors, kColors, "What the channels of pictures are")
      .parameter("material", options.material, std::vector<std::string>{},
                 "Whose patch it is: the material's name in the texture")
      .parameter("layout", options.rewriting.layout, formats::kBtfWrittenLayouts, "Of the written .btf")
      .parameter("color_model", options.rewriting.model, formats::kBtfWrittenModels, "Of a factorized .btf")
      .parameter("rank", options.rewriting.rank, {1, 1024}, "",
                 "Products a channel of a factorized .btf at most")
      .parameter("precision", options.is_float, kPrecisions, "Of texture and factorized .btf");
}

std::shared_ptr<const formats::Btf> opened(Options& options, stage::Run& run) {
  const bool is_pictures = formats::isPictureSet(options.measured);
  if (!is_pictures && !options.pictures.table.empty())
    throw badInput({options.pictures.table.string(), "", ""},
                   "a table of directions is given for a .btf file", "one for a folder or zip of pictures");
  std::shared_ptr<const formats::Btf> btf = is_pictures
                                                ? formats::openBtfPictures(options.measured, options.pictures)
                                                : formats::openBtf(options.measured);
  for (const std::string& note : btf->info().notes) run.warn(note);
  options.projection.scale = options.scale.value_or(is_pictures ? 1 / std::numbers::pi : 1);
  if (is_pictures && !options.scale && !(options.rtt.empty() && options.btfs.empty()))
    run.warn("values of pictures are taken relative to a white diffuser: they are divided by pi (scale)");
  return btf;
}

std::shared_ptr<const formats::Btf> reduced(const std::shared_ptr<const formats::Btf>& btf,
                                            const Options& options, stage::Run& run) {
  btf::Crop crop = options.crop;
  const auto extent = [](int begin, int size, int all) {
    return std::min(size > 0 ? size : all, all - begin);
  };
  const int longer = std::max(extent(crop.left, crop.width, btf->info().width),
                              extent(crop.top, crop.height, btf->info().height));
  crop.shrink = std::max((longer + options.resolution - 1) / options.resolution, 1);
  int dropped = 0;
  auto result = btf::cropped(btf, crop, &dropped);
  if (dropped > 0)
    run.warn(std::to_string(dropped) + " texels at the right and the bottom are left out: they do not fill " +
             std::to_string(crop.shrink) + " × " + std::to_string(crop.shrink));
  run.stat("texels_averaged", crop.shrink * crop.shrink);
  run.stat("texels_left_out", dropped);
  return result;
}

formats::Json describe(const formats::Btf& btf) {
  const formats::BtfInfo& info = btf.info();
  std::size_t pictures = 0;
  for (std::size_t v = 0; v < info.views.size(); ++v) pictures += btf.lightsOf(static_cast<int>(v)).size();
  return {{"layout", info.layout},
          {"views", info.views.size()},
          {"lights", info.lights.size()},
          {"pictures", pictures},
          {"missing_pictures", info.views.size() * info.lights.size() - pictures},
          {"width_texels", info.width},
          {"height_texels", info.height},
          {"cosine_inside", info.cosine_inside},
          {"file_bytes", info.bytes},
          {"expanded_bytes", 12.0 * static_cast<double>(pictures) * static_cast<double>(btf.texelCount())}};
}

// One of those whose tables are written, with what its file asks for.
struct Kept {
  std::string material;
  std::shared_ptr<const formats::Btf> btf;
  btf::ProjectionOptions projection;
};

void writeTables(const Options& options, const std::vector<Kept>& all, stage::Run& run) {
  const int views = options.projection.views;
  std::vector<formats::BtfTableShape> shapes;
  std::size_t steps = 0;
  for (const Kept& kept : all) {
    shapes.push_back(
        {kept.material, views, options.grid.lights, kept.btf->info().width, kept.btf->info().height});
    steps += kept.btf->info().views.size();
    constexpr double kMost = 4.3e9;
    if (const double bytes = 4.0 * static_cast<double>(shapes.back().valueCount()); bytes > kMost)
      throw Error(ExitStatus::kUsage, {"", "--btfs", ""},
                  "a table of that size takes " + std::to_string(bytes / 1e9) + " GB",
                  std::to_string(kMost / 1e9) + " of memory at most",
                  "lessen resolution, views or btf_lights");
  }
  stage::Progress progress = run.progress("resampling", steps, "views");
  formats::BtfTableWriter writer(options.btfs, shapes);
  for (const Kept& kept : all)
    writer.append(kept.material,
                  btf::resample(*kept.btf, kept.projection, options.grid, [&] { progress.advance(); }));
  writer.finish();
}

struct NamedTexture {
  formats::RadianceTransferTexture texture;
  formats::Json stats;
};

NamedTexture projectTexture(const formats::Btf& btf, const Options& options, stage::Run& run) {
  stage::Progress progress = run.progress("projecting", btf.info().views.size(), "views");
  btf::Projected projected = btf::project(btf, options.projection, [&] { progress.advance(); });
  projected.texture.material = options.material;
  const btf::ProjectionFigures& figures = projected.figures;
  formats::Json stats = {{"scale", options.projection.scale},
                         {"interpolated_jointly", figures.is_joint},
                         {"views_left_out", figures.views_left_out},
                         {"view_gap_deg", figures.view_gap_deg},
                         {"light_gap_deg", figures.light_gap_deg},
                         {"mean_radiance_under_uniform_sky", figures.mean_radiance},
                         {"largest_view_radiance_under_uniform_sky", figures.largest_view_radiance},
                         {"view_dependence", figures.view_dependence}};
  constexpr double kWide_deg = 45;
  if (std::max(figures.view_gap_deg, figures.light_gap_deg) > kWide_deg)
    run.warn("directions leave gaps of " + std::to_string(figures.view_gap_deg) + "° (views) and " +
             std::to_string(figures.light_gap_deg) + "° (lights): what lies within is a guess");
  if (figures.views_left_out > 0)
    run.warn(std::to_string(figures.views_left_out) +
             " views are left out: pictures under half of the lights are missing");
  if (figures.largest_view_radiance > 1 + 1e-3)
    run.warn("under a sky of 1 it reflects " + std::to_string(figures.largest_view_radiance) +
             " towards a view, more than it receives: scale or cosine may be meant otherwise");
  return {std::move(projected.texture), std::move(stats)};
}

void writeTextures(const Options& options, std::span<const formats::RadianceTransferTexture> textures) {
  formats::writeRadianceTransferTextures(
      options.rtt, textures, options.is_float ? formats::ExrPrecision::kFloat : formats::ExrPrecision::kHalf);
}

void tell(const formats::Json& stats, stage::Run& run) {
  for (const auto& [name, value] : stats.items()) run.stat(name, value);
}

void rewrite(const formats::Btf& btf, Options& options, stage::Run& run) {
  options.rewriting.precision =
      options.is_float ? formats::BtfPrecision::kFloat : formats::BtfPrecision::kHalf;
  const btf::RewritingFigures figures = btf::rewrite(btf, options.written, options.rewriting);
  run.stat("written_bytes", figures.bytes);
  run.stat("written_error", figures.relative_error);
  if (options.rewriting.layout == formats::BtfWrittenLayout::kFactorized) {
    run.stat("ranks", figures.ranks);
    run.stat("channel_errors", figures.channel_errors);
  }
  if (figures.negative_values > 0)
    run.warn(std::to_string(figures.negative_values) +
             " negative values are written as 0: the colour model has none");
}

void runOne(Options& options, stage::Run& run) {
  const std::shared_ptr<const formats::Btf> measured = opened(options, run);
  tell(describe(*measured), run);
  const std::shared_ptr<const formats::Btf> kept = reduced(measured, options, run);
  if (!options.rtt.empty()) {
    const NamedTexture made = projectTexture(*kept, options, run);
    writeTextures(options, std::span(&made.texture, 1));
    tell(made.stats, run);
  }
  if (!options.btfs.empty()) writeTables(options, {{options.material, kept, options.projection}}, run);
  if (!options.written.empty()) rewrite(*kept, options, run);
}

// Each patch that is a measured BTF; none is no mistake, as recipes ask how many there are.
void runMaterials(Options& options, stage::Run& run) {
  if (!options.written.empty())
    throw Error(ExitStatus::kUsage, {"", "--written", ""}, "a material's BTFs are not written again", "",
                "name one BTF by --measured");
  const formats::Materials materials = formats::readMaterials(options.material_file);
  std::vector<formats::RadianceTransferTexture> textures;
  formats::Json stats = formats::Json::array();
  double view_dependence = 0;
  std::vector<Kept> all;
  const auto take = [&](const std::string& name, const formats::Material& material) {
    if (!material.patch || material.patch->btf.empty()) return;
    options.measured = material.patch->btf, options.material = name;
    const std::shared_ptr<const formats::Btf> measured = opened(options, run);
    all.push_back({name, reduced(measured, options, run), options.projection});
    NamedTexture made = projectTexture(*all.back().btf, options, run);
    formats::Json told = describe(*measured);
    told.update(made.stats);
    told["material"] = name;
    view_dependence = std::max(view_dependence, told.at("view_dependence").get<double>());
    stats.push_back(std::move(told));
    textures.push_back(std::move(made.texture));
  };
  take("", materials.base);
  for (const auto& [name, material] : materials.by_name) take(name, material);
  if (textures.empty() && !(options.rtt.empty() && options.btfs.empty()))
    throw badInput({options.material_file.string(), "", "/patch"}, "no material's patch is a measured BTF",
                   "a \"patch\" with a \"btf\"");
  if (!options.rtt.empty()) writeTextures(options, textures);
  if (!options.btfs.empty()) writeTables(options, all, run);
  run.stat("patches", textures.size());
  run.stat("view_dependence", view_dependence);
  run.stat("textures", std::move(stats));
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  stage::Tool tool(
      "btf",
      "Reads a measured BTF, projects it to a radiance transfer texture and writes it as a .btf file.");
  declare(tool, options);
  return tool.run(argc, argv, [&](stage::Run& run) {
    if (options.measured.empty() == options.material_file.empty())
      throw Error(ExitStatus::kUsage, {"", "--measured", ""},
                  "either a BTF or a material whose patches name some is read",
                  "--measured FILE or --material-file FILE");
    if (options.material_file.empty())
      runOne(options, run);
    else
      runMaterials(options, run);
  });
}
