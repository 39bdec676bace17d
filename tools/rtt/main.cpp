// rtt: what the patches of materials send towards each view, of each spherical harmonic of the light on them.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/material.h"
#include "patch/read_patch.h"
#include "tools/rtt/btf_output.h"
#include "tools/rtt/rtt.h"
#include "tools/rtt/view_dependence.h"
#include "tools/stage/stage.h"
#include "transport/ray_scene.h"

using namespace bakelight;

namespace {

struct NamedMaterial {
  std::string name;
  const formats::Material* material;
};

// Those with a patch; "" is the asset's own.
std::vector<NamedMaterial> withPatches(const formats::Materials& materials) {
  std::vector<NamedMaterial> named;
  const auto take = [&](const std::string& name, const formats::Material& material) {
    if (material.patch) named.push_back({name, &material});
  };
  take("", materials.base);
  for (const auto& [name, material] : materials.by_name) take(name, material);
  return named;
}

formats::Json toJson(const std::string& name, const rtt::Rtt& made) {
  const rtt::Figures& figures = made.figures;
  formats::Json json = {{"material", name},
                        {"width", made.texture.width},
                        {"height", made.texture.height},
                        {"surface_triangles", figures.surface_triangles},
                        {"surface_points", figures.surface_points},
                        {"depth", figures.depth},
                        {"hole_share", figures.hole_share},
                        {"glossy_rays", figures.glossy_rays},
                        {"longest_edge", figures.longest_edge},
                        {"view_dependence", figures.view_dependence.from_mean},
                        {"view_dependence_from_head_on", figures.view_dependence.from_head_on},
                        {"inside_share", figures.inside_share},
                        {"mean_albedo", figures.mean_albedo}};
  if (figures.bounced) {
    json["form_factors"] = figures.form_factors;
    json["buried_points"] = figures.buried_points;
    json["bounce_passes"] = figures.bounced->added_energy.size();
    json["bounce_energy"] = figures.bounced->added_energy;
    json["bounce_solver"] = figures.bounced->solver;
    json["bounce_error_bound"] = figures.bounced->error_bound;
  }
  return json;
}

// Of the material in the file that btf made of the measured ones.
formats::RadianceTransferTexture measuredTexture(const NamedMaterial& each,
                                                 const std::filesystem::path& file) {
  const std::string whose = each.name.empty() ? "the asset's own material" : "\"" + each.name + "\"";
  if (file.empty())
    throw badInput({each.material->patch->btf.string(), "", "/patch/btf"},
                   "the patch of " + whose + " is a measured BTF, which btf projects",
                   "its texture (measured)",
                   "run btf --material-file first, and give rtt what it wrote; the recipe biscale does");
  for (formats::RadianceTransferTexture& texture : formats::readRadianceTransferTextures(file))
    if (texture.material == each.name) return std::move(texture);
  throw badInput({file.string(), "", ""}, "it has no texture of " + whose, "one for each measured patch",
                 "make it by btf --material-file of the same material");
}

// As its file has it, but for the name.
formats::RadianceTransferTexture readyMade(const NamedMaterial& each, const std::filesystem::path& measured,
                                           const rtt::Options& options) {
  const formats::Patch& patch = *each.material->patch;
  const std::filesystem::path& file = patch.rtt.empty() ? measured : patch.rtt;
  formats::RadianceTransferTexture texture =
      patch.rtt.empty() ? measuredTexture(each, measured)
                        : std::move(formats::readRadianceTransferTextures(file).front());
  if (texture.order != options.order)
    throw badInput({file.string(), "order", ""}, "it has " + std::to_string(texture.order) + " bands",
                   std::to_string(options.order) + ", as the textures beside it",
                   "make it again at that order, or give rtt this one's");
  texture.material = each.name;
  return texture;
}

int wholeNumber(double bounces) {
  if (bounces != std::floor(bounces))
    throw Error(ExitStatus::kUsage, {"", "--bounces", ""}, "half a bounce does not exist",
                "a whole number, or all");
  return static_cast<int>(bounces);
}

// A `.btf` file holds one.
void requireOnePatch(const std::vector<NamedMaterial>& named, const std::filesystem::path& file) {
  const auto rendered = std::count_if(named.begin(), named.end(), [](const NamedMaterial& each) {
    return each.material->patch->hasSurface();
  });
  if (rendered != 1)
    throw badInput({file.string(), "", "/patch"},
                   std::to_string(rendered) + " materials have a patch with a surface, and a .btf holds one",
                   "one", "ask for --btfs, which are of all materials, or run rtt for each on its own");
}

// Of a material whose patch is measured: the table that btf made.
formats::BtfTable measuredTable(const NamedMaterial& each, const rtt::BtfOutput& output) {
  const formats::Patch& patch = *each.material->patch;
  const std::string whose = each.name.empty() ? "the asset's own material" : "\"" + each.name + "\"";
  if (patch.btf.empty())
    throw badInput(
        {patch.rtt.string(), "", "/patch/rtt"},
        "the patch of " + whose + " is a radiance transfer texture, which knows no directions of light",
        "a surface, or a measured BTF", "give it \"height\", \"geometry\" or \"btf\"");
  if (output.measured.empty())
    throw badInput(
        {patch.btf.string(), "", "/patch/btf"},
        "the patch of " + whose + " is a measured BTF, which btf brings to these directions",
        "its table (measured_btfs)",
        "run btf --material-file with --btfs first, and give rtt what it wrote; the recipe allfreq does");
  for (formats::BtfTable& table : formats::readBtfTables(output.measured)) {
    if (table.material != each.name) continue;
    if (table.lights != output.options.lights)
      throw badInput(
          {output.measured.string(), "", "/btf_lights"},
          "it has " + std::to_string(table.lights) + " × " + std::to_string(table.lights) + " cells of light",
          std::to_string(output.options.lights) + " × " + std::to_string(output.options.lights),
          "give btf and rtt the same btf_lights");
    return std::move(table);
  }
  throw badInput({output.measured.string(), "", ""}, "it has no BTF of " + whose,
                 "one for each measured patch", "make it by btf --material-file of the same material");
}

void requireRoom(const rtt::Options& options, double aspect) {
  constexpr double kMostValues = 2e9;
  const double values =
      std::pow(options.resolution * options.views, 2) * aspect * 3 * std::pow(options.order, 2);
  if (values > kMostValues)
    throw Error(ExitStatus::kUsage, {"", "--resolution", ""},
                "a texture of that size has " + std::to_string(values / 1e9) + " thousand million values",
                "2 at most", "lessen resolution, views or order");
}

void warnOf(const NamedMaterial& each, const rtt::Figures& figures, const rtt::Options& options,
            stage::Run& run) {
  constexpr double kSeldom = 1e-3;
  const formats::Patch& patch = *each.material->patch;
  const std::string file = (patch.height     ? patch.height->file
                            : patch.geometry ? patch.geometry->file
                                             : patch.file)
                               .string();
  if (figures.inside_share > kSeldom)
    run.warn(file + ": " + std::to_string(100 * figures.inside_share) +
             " % of what views meet is the inside of closed parts, and black: are faces turned inside out?");
  if (figures.longest_edge * options.elements > 1 + 1e-9)
    run.warn(file + ": its surface is so large that light is solved on edges of " +
             std::to_string(figures.longest_edge) + " widths of the patch");
  if (figures.bounced && !figures.bounced->converged && figures.bounced->error_bound > 0)
    run.warn(file + ": light of further bounces is missing, at most " +
             std::to_string(100 * figures.bounced->error_bound) + " %");
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path material_path, measured_path, rtt_path;
  rtt::Options options;
  std::optional<double> bounces;
  rtt::BtfOutput btf;
  stage::Tool tool(
      "rtt",
      "Renders patches of meso-structure towards all views, for light in spherical harmonics, and "
      "from each direction");
  tool.input("material", "material", material_path,
             "Each material's \"patch\" that has a surface (\"height\" or \"geometry\") is rendered",
             {.required = true, .parts = {"albedo", "reflection", "patch"}})
      .input("measured", "rtt", measured_path, "What btf made of the materials whose patch is a measured BTF",
             false)
      .output("rtt", "rtt", rtt_path, "EXR: a radiance transfer texture for each such material", false)
      .parameter("resolution", options.resolution, {1, 2048}, "texels", "Of a texture, across")
      .parameter(
          "views", options.views, {1, 32}, "",
          "A side of the grid of views over the hemisphere; 1: that from straight above stands for all")
      .parameter("supersampling", options.supersampling, {1, 16}, "", "Points a texel, a side")
      .parameter("order", options.order, {1, 10}, "bands", "Of spherical harmonics of the light")
      .parameter("lights", options.light_rule, rtt::kLightRules,
                 "gauss_legendre: in height, exact on a flat patch; polar: even in the polar angle, as the "
                 "paper has it")
      .parameter("polar_lights", options.polar_lights, {1, 256}, "",
                 "Directions of light from zenith to horizon")
      .parameter("azimuth_lights", options.azimuth_lights, {1, 512}, "",
                 "Directions of light around the zenith")
      .parameter("bounces", bounces, {{"all", std::nullopt}}, {0, 1000},
                 "Reflections between diffuse surfaces; all: by a solver")
      .parameter("bounce_directions", options.bounce_directions, {16, 65536}, "",
                 "Over the sphere, in which the surface looks for itself")
      .parameter("elements", options.elements, {1, 4096}, "",
                 "Across the patch: light is solved on triangles with edges of at most one")
      .parameter("glossy_samples", options.glossy_samples, {16, 4096}, "",
                 "Directions that each look at a glossy surface goes on to, rounded up to batches of 16")
      .parameter("shadows", options.shadows, "Light is blocked by the surface")
      .parameter("masking", options.masking,
                 "A view sees along its direction; without, all see what lies straight below")
      .executionPath(transport::RayScene::executionPath);
  rtt::declare(tool, btf);

  return tool.run(argc, argv, [&](stage::Run& run) {
    if (bounces) options.bounces = wholeNumber(*bounces);
    const formats::Materials materials = formats::readMaterials(material_path);
    const std::vector<NamedMaterial> named = withPatches(materials);
    if (named.empty())
      throw badInput({material_path.string(), "", "/patch"}, "no material has a patch",
                     "a \"patch\" with \"height\", \"geometry\", \"file\", \"btf\" or \"rtt\"",
                     "add one to a material's \"patch\"");
    if (!btf.path.empty()) requireOnePatch(named, material_path);
    std::vector<rtt::BtfSource> btfs;
    stage::Progress progress =
        run.progress("rtt", named.size() * static_cast<std::size_t>(options.views) * options.views, "views");
    const auto start = std::chrono::steady_clock::now();
    std::vector<formats::RadianceTransferTexture> textures;
    formats::Json stats = formats::Json::array();
    std::uint64_t rays = 0;
    double view_dependence = 0;
    for (const NamedMaterial& each : named) {
      if (const formats::Patch& patch = *each.material->patch; !patch.hasSurface()) {
        if (!btf.tables.empty()) btfs.push_back({each.name, std::nullopt, measuredTable(each, btf)});
        progress.advance(options.views * options.views);
        stats.push_back(
            {{"material", each.name}, {"file", (patch.rtt.empty() ? patch.btf : patch.rtt).string()}});
        if (rtt_path.empty() && !btf.tables.empty()) continue;  // tables alone need no texture
        textures.push_back(readyMade(each, measured_path, options));
        view_dependence = std::max(view_dependence, rtt::viewDependence(textures.back()).from_head_on);
        continue;
      }
      const patch::PatchGeometry geometry = patch::readPatch(*each.material);
      for (const std::string& note : geometry.notes) run.warn(note);
      requireRoom(options, geometry.aspect);
      if (btf.isWanted()) rtt::requireRoom(btf, geometry, options, run);
      rtt::Rtt made = rtt::makeRtt(geometry, options, [&] { progress.advance(1); });
      made.texture.material = each.name;
      warnOf(each, made.figures, options, run);
      rays += made.figures.rays;
      view_dependence = std::max(view_dependence, made.figures.view_dependence.from_head_on);
      stats.push_back(toJson(each.name, made));
      textures.push_back(std::move(made.texture));
      if (btf.isWanted()) btfs.push_back({each.name, geometry, std::nullopt});
    }
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (!rtt_path.empty()) formats::writeRadianceTransferTextures(rtt_path, textures);
    if (btf.isWanted()) run.stat("btfs", rtt::makeAndWrite(btf, btfs, options, run));
    run.stat("textures", stats);
    run.stat("view_dependence", view_dependence);
    run.stat("seconds", seconds);
    run.stat("rays", rays);
    run.stat("rays_per_s", static_cast<double>(rays) / seconds);
  });
}
