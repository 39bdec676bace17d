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

// So far one medium an object.
formats::Medium mediumOf(const formats::Materials& materials, const std::string& file) {
  const std::vector<std::string> names = formats::translucentMaterials(materials);
  if (names.empty())
    throw badInput({file, "", "/medium"}, "no material has a medium", "one",
                   R"(give it "medium": { "name": "marble" })");
  const formats::Medium& medium = *materials.of(names.front()).medium;
  for (const std::string& name : names)
    if (materials.of(name).medium != medium)
      throw badInput({file, "", "/materials/" + name + "/medium"}, "it is of another medium than the others",
                     "one medium", "bake objects of different media apart");
  if (!materials.base.medium && !materials.by_name.empty())
    throw badInput({file, "", "/material"}, "only a part of the object has a medium", "all of it",
                   "bake it apart from what is opaque");
  return medium;
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
  run.stat("rank_deficient_texels", f.rank_deficient);
  run.stat("kernel_components", f.components);
  run.stat("kernel_error", f.kernel_error);
  run.stat("seconds", f.seconds);
  run.stat("bytes", made.translucency.bytes());
  constexpr double kCoarse = 8, kFew = 0.1;
  if (f.texels_per_spacing > kCoarse)
    run.warn("vertices are " + std::to_string(f.texels_per_spacing) +
             " texels apart, more than kernels of 7 × 7 texels and hats between vertices go together for (5 "
             "or so): "
             "more triangles or fewer texels will err less");
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
    const formats::TriangleMesh mesh = formats::readPly(mesh_path);
    const formats::Medium medium = mediumOf(formats::readMaterials(material_path), material_path.string());
    const kernels::Made made =
        kernels::makeTranslucency(mesh, maps_path, medium, options, run.progressStyle());
    formats::PackPart part(made.translucency);
    formats::writeSafetensors(kernels_path, formats::tensorsOf(part));
    report(made, run);
  });
}
