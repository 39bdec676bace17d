#include <filesystem>
#include <optional>
#include <utility>

#include "formats/material.h"
#include "formats/mesh_ply.h"
#include "formats/pack.h"
#include "formats/patch_albedo.h"
#include "formats/tensors.h"
#include "formats/words.h"
#include "tools/pack/neighborhood_packing.h"
#include "tools/pack/packing.h"
#include "tools/pack/report.h"
#include "tools/pack/transfer_reader.h"
#include "tools/pack/translucency_packing.h"
#include "tools/stage/stage.h"

using namespace bakelight;

namespace {

constexpr const char* kReflectionNow =
    R"(a material: in asset.json "material": { "reflection": { "model": "ggx", "roughness": 0.3, )"
    R"("specular_color": [0.2, 0.2, 0.2] } })";

// Whether materials wear their patches.
enum class Patches { kWorn, kNone };
constexpr formats::Word<Patches> kPatches[] = {{"worn", Patches::kWorn}, {"none", Patches::kNone}};

formats::Materials withoutPatches(formats::Materials materials) {
  materials.base.patch.reset();
  for (auto& [name, material] : materials.by_name) material.patch.reset();
  return materials;
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path mesh_path, material_path, transfer_path, brdf_path, rtt_path, btf_path, btfs_path,
      id_map_path, kernels_path, neighborhood_path, pack_path;
  formats::Precision neighborhood_precision = formats::Precision::kFloat16;
  packing::PackingOptions options;
  formats::PackOptions file_options;
  Patches worn = Patches::kWorn;

  stage::Tool tool("pack", "Puts a mesh and its baked transfer together as one pack, a binary glTF file.");
  tool.input("mesh", "mesh", mesh_path, "PLY mesh that the transfer was baked for")
      .input("transfer", "tensors", transfer_path, "safetensors file of the transfer tool, or of bicluster")
      .input("material", "material", material_path, "what the mesh is made of, the one that was baked with",
             false)
      .input("brdf", "tensors", brdf_path, "With reflection table: safetensors file of the brdf tool", false)
      .input("rtt", "rtt", rtt_path,
             "Radiance transfer textures of the materials' patches, as rtt writes them", false)
      .input("btf", "btf", btf_path,
             "With transfer in a pixel basis: the BTF of the material's patch, as rtt writes it, for all "
             "materials that have none of their own",
             false)
      .input("btfs", "tensors", btfs_path,
             "With transfer in a pixel basis: the BTFs of all materials' patches, as rtt writes them", false)
      .input("id_map", "id_map", id_map_path,
             "Which place of its patch each texel shows; without it, texture coordinates lay the patches out",
             false)
      .input("kernels", "tensors", kernels_path,
             "How light goes through the mesh, as kernels writes it for a material with a medium", false)
      .input("neighborhood", "tensors", neighborhood_path,
             "What the object does to the light around it, as neighborhood writes it for this mesh", false)
      .output("pack", "pack", pack_path, "binary glTF file (.glb)")
      .parameter("name", options.name, {}, "Name of the asset, shown by glTF viewers")
      .parameter("precision", options.precision, formats::kPrecisions,
                 "Numbers of matrices, visibility or weights (cpca's basis: float16 instead of uint8)")
      .parameter(
          "reflection", options.reflection, packing::kShownReflections,
          "How the material's glossy reflection is shown: as a lobe around the mirror direction, by the "
          "table of brdf, or not at all")
      .parameter(
          "rtt_error", options.rtt.error, {0, 1}, "",
          "Relative error that principal components of radiance transfer textures may leave; 0 keeps all")
      .parameter(
          "relief", options.rtt.relief,
          "Look views of deep patches up where each sees the same point, by heights; else all at one place "
          "of the mid-plane, where they show it twice")
      .parameter("btf_error", options.btf.error, {0, 1}, "",
                 "Relative error that BTFs may have in the pack: their code's step and components are found "
                 "for it; 0 "
                 "keeps all components, as a table")
      .parameter("btf_precision", options.btf.precision, formats::kPrecisions,
                 "Numbers of BTFs' factors as they are played")
      .parameter("crease_angle", options.crease_angle, {0, 180}, "degrees",
                 "Pixel basis: corners whose frames differ by more are not interpolated between")
      .parameter("patches", worn, kPatches,
                 "none: surfaces are smooth, whatever patches their materials have")
      .parameter("neighborhood_precision", neighborhood_precision, formats::kPrecisions,
                 "Numbers of ground and volume of the neighborhood")
      .parameter("draco", file_options.draco, "Compress the mesh with Draco, for distribution")
      .parameter("position_bits", file_options.position_bits, {0, 30}, "bits",
                 "With draco: quantise positions to 8 to 30 bits an axis; 0 keeps them exact")
      .parameter("normal_bits", file_options.normal_bits, {0, 30}, "bits",
                 "With draco: quantise normals to 6 to 30 bits an axis; 0 keeps them exact")
      .retired("albedo", R"(a material: in asset.json "material": { "albedo": [0.8, 0.8, 0.8] })");
  for (const char* was : {"lobe", "exponent", "roughness", "specular_color"})
    tool.retired(was, kReflectionNow);

  return tool.run(argc, argv, [&](stage::Run& run) {
    packing::checkOptions(file_options);
    const formats::TensorFile transfer = formats::readSafetensors(transfer_path);
    std::optional<formats::TensorFile> brdf;
    if (!brdf_path.empty()) brdf = formats::readSafetensors(brdf_path);
    formats::TriangleMesh mesh = formats::readPly(mesh_path);
    packing::PatchSources patches;
    if (!rtt_path.empty() || !btf_path.empty() || !btfs_path.empty())
      patches = packing::readPatchSources(rtt_path, id_map_path);
    formats::Materials materials = formats::readMaterialsOrDefault(material_path);
    if (worn == Patches::kNone) materials = withoutPatches(std::move(materials));
    std::optional<formats::Translucency> translucency;
    if (!kernels_path.empty()) translucency = packing::readTranslucency(kernels_path, mesh);
    for (const std::string& name : formats::translucentMaterials(materials))
      if (!translucency)
        run.warn("the medium of " + (name.empty() ? "the asset's own material" : "\"" + name + "\"") +
                 " is left out: without kernels a pack shows its albedo as diffuse reflection, of what "
                 "enters it alone");
    packing::takeMaterials(materials, patches);
    if (!btfs_path.empty())
      for (formats::BtfTable& table : formats::readBtfTables(btfs_path))
        patches.tables.emplace(table.material, table);
    if (!btf_path.empty()) patches.btfs[""] = formats::openBtf(btf_path);
    // In a directional basis; without transfer for them, they are none of this tool's business.
    if (packing::isPixelTechnique(transfer.requireMetadata("technique", transfer_path.string())))
      packing::takeBtfs(materials, patches);
    formats::takePatchAlbedo(materials, patches.textures);
    options.material = formats::materialsOn(mesh, materials, mesh_path.string(), material_path.string());
    std::vector<packing::TextureFigures> textures;
    const formats::Pack pack =
        packing::assemblePack(std::move(mesh), transfer, brdf ? &*brdf : nullptr, options,
                              {mesh_path.string(), transfer_path.string(), brdf_path.string(),
                               material_path.string(), rtt_path.string(), id_map_path.string()},
                              patches, &textures);
    formats::Pack ordered = pack;
    if (translucency)
      packing::makeTranslucent(std::move(*translucency), kernels_path.string(), transfer,
                               transfer_path.string(), ordered);
    if (!neighborhood_path.empty()) {
      packing::PackedNeighborhood neighborhood =
          packing::readNeighborhood(neighborhood_path, pack.mesh, mesh_path.string(), neighborhood_precision);
      run.stat("neighborhood_error", neighborhood.errors);
      ordered.neighborhood = std::move(neighborhood.part);
    }
    if (const std::size_t dropped = packing::orderByMaterial(ordered); dropped > 0)
      run.warn(std::to_string(dropped) + " vertices without a triangle were left out");
    const formats::Bytes bytes = formats::encodePack(ordered, file_options, pack_path.string());
    formats::writeFileAtomically(pack_path, bytes);
    packing::report(pack, transfer, bytes, pack_path.string(), run);
    if (!textures.empty()) run.stat("textures", packing::toJson(textures));
    packing::warnOfLobe(pack, options.material, run);
  });
}
