// kernels: how light goes through a translucent object.
#include <filesystem>
#include <string>

#include "formats/error.h"
#include "formats/material.h"
#include "formats/mesh_ply.h"
#include "formats/part_tensors.h"
#include "tools/kernels/kernels.h"
#include "tools/stage/stage.h"

using namespace bakelight;

namespace {

// The one that all faces of the mesh are of. The mesh's colors become what it reflects, where that is the albedo.
formats::Medium takeMedium(formats::TriangleMesh& mesh, const std::string& mesh_file,
                           const std::filesystem::path& material_file) {
  const std::string file = material_file.string();
  const formats::SurfaceMaterials surface =
      formats::materialsOn(mesh, formats::readMaterials(material_file), mesh_file, file);
  for (std::size_t i = 0; i < surface.media.size(); ++i) {
    const std::string whose =
        surface.names[i].empty() ? "the asset's own material" : "\"" + surface.names[i] + "\"";
    if (!surface.media[i])
      throw badInput({file, whose, "/medium"}, "the mesh has faces of it, and it has no medium", "one",
                     R"(give it "medium": { "name": "marble" }; bake what is opaque apart)");
    if (surface.media[i] != surface.media.front())
      throw badInput({file, whose, "/medium"},
                     "it is of another medium than \"" + surface.names.front() + "\"", "one medium",
                     "bake parts of different media apart");
  }
  mesh.colors = surface.medium_reflectance;
  return *surface.media.front();
}

void report(const kernels::Made& made, stage::Run& run) {
  const kernels::Figures& f = made.figures;
  run.stat("knots", f.knots);
  run.stat("far_knots", f.far_knots);
  run.stat("near_entries", f.near_entries);
  run.stat("texels", f.texels);
  run.stat("receivers", f.receivers);
  run.stat("texels_per_spacing", f.texels_per_spacing);
  run.stat("mean_free_path_texels", f.mean_free_path_texels);
  run.stat("window_share", f.window_share);
  run.stat("near_dropped_share", f.near_dropped_share);
  run.stat("apart_pairs", f.apart_pairs);
  run.stat("touching_knots", f.touching_knots);
  run.stat("rank_deficient_texels", f.rank_deficient);
  run.stat("clamped_texels", f.clamped);
  run.stat("clamped_reflectances", f.clamped_reflectances);
  run.stat("kernel_components", f.components);
  run.stat("kernel_error", f.kernel_error);
  run.stat("seconds", f.seconds);
  run.stat("bytes", made.translucency.bytes());
  constexpr double kCoarse = 8, kFew = 0.1, kMuch = 0.005;
  if (f.texels_per_spacing > kCoarse)
    run.warn("vertices are " + std::to_string(f.texels_per_spacing) +
             " texels apart, more than kernels of 7 × 7 texels and hats between vertices go together for (5 "
             "or so): "
             "more triangles or fewer texels will err less");
  if (f.touching_knots > 0)
    run.warn(std::to_string(f.touching_knots) +
             " vertices touch another part of the surface, and light between the two is blurred: leave out "
             "parts inside "
             "others (simplify --least-part), or weld them");
  if (f.clamped > 0)
    run.warn(
        std::to_string(f.clamped) + " of " + std::to_string(f.texels) +
        " texels would have given their vertices more than twice what falls on them, and were held to that");
  if (f.clamped_reflectances > 0)
    run.warn(std::to_string(f.clamped_reflectances) + " vertices have colors below " +
             std::to_string(transport::MediumField::kLeastReflectance) +
             " or above 1, which are taken for these: no medium reflects nothing, or more than it gets");
  if (f.near_dropped_share > kMuch)
    run.warn("factors below the threshold are up to " + std::to_string(100 * f.near_dropped_share) +
             " % of what leaves a vertex, and were dropped: lower threshold");
  if (static_cast<double>(f.rank_deficient) > kFew * static_cast<double>(f.texels))
    run.warn(std::to_string(f.rank_deficient) + " of " + std::to_string(f.texels) +
             " texels have too few others around them to determine their weights: more texels will err less");
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path mesh_path, maps_path, material_path, kernels_path;
  kernels::Options options;
  stage::Tool tool(
      "kernels", "How light goes through a translucent object: kernels of texels, factors between vertices.");
  tool.input("mesh", "mesh", mesh_path, "PLY mesh that atlas wrote")
      .input("maps", "image", maps_path, "Its geometry maps, with a border of 4 texels or more")
      .input("material", "material", material_path, "With a \"medium\"",
             {.required = true, .parts = {"medium"}})
      .output("kernels", "tensors", kernels_path, "safetensors file, for pack")
      .parameter("kernel_error", options.kernel_error, {0, 1}, "",
                 "Relative error that principal components of kernels may leave; 0 keeps all")
      .parameter("threshold", options.factors.threshold, {0, 1}, "",
                 "Factors between vertices below this share of what enters around one are dropped")
      .parameter("hierarchical", options.factors.hierarchical,
                 "What goes far between fewer, farther points; else a factor between any two vertices");
  return tool.run(argc, argv, [&](stage::Run& run) {
    formats::TriangleMesh mesh = formats::readPly(mesh_path);
    const formats::Medium medium = takeMedium(mesh, mesh_path.string(), material_path);
    const kernels::Made made =
        kernels::makeTranslucency(mesh, maps_path, medium, options, run.progressStyle());
    formats::PackPart part(made.translucency);
    formats::writeSafetensors(kernels_path, formats::tensorsOf(part));
    report(made, run);
  });
}
