#include <filesystem>
#include <optional>

#include "formats/mesh_ply.h"
#include "formats/pack.h"
#include "formats/tensors.h"
#include "tools/pack/packing.h"
#include "tools/pack/report.h"
#include "tools/stage/stage.h"

using namespace bakelight;

int main(int argc, char** argv) {
  std::filesystem::path mesh_path, transfer_path, brdf_path, pack_path;
  packing::PackingOptions options;
  formats::PackOptions file_options;
  std::string precision = nameOf(options.precision);

  stage::Tool tool("pack", "Puts a mesh and its baked transfer together as one pack, a binary glTF file.");
  tool.input("mesh", "mesh", mesh_path, "PLY mesh that the transfer was baked for")
      .input("transfer", "tensors", transfer_path, "safetensors file of the transfer tool")
      .input("brdf", "tensors", brdf_path, "With lobe table: safetensors file of the brdf tool", false)
      .output("pack", "pack", pack_path, "binary glTF file (.glb)")
      .parameter("name", options.name, {}, "Name of the asset, shown by glTF viewers")
      .parameter("albedo", options.albedo, {0, 1}, "",
                 "Diffuse reflectance, linear red, green and blue; the transfer's albedo wins if it has one, "
                 "or else "
                 "the mesh's colours")
      .parameter("precision", precision, formats::precisionNames(),
                 "Numbers of matrices, visibility or weights (cpca's basis: float16 instead of uint8)")
      .parameter("lobe", options.lobe, packing::lobeNames(), "Glossy reflection, for a glossy transfer")
      .parameter("exponent", options.exponent, {0, 100000}, "", "With lobe phong: exponent of the cosine")
      .parameter("roughness", options.roughness, {0, 1}, "", "With lobe ggx: square root of GGX's alpha")
      .parameter("specular_color", options.specular_color, {0, 1}, "",
                 "With lobe phong or ggx: its reflectance, linear red, green and blue")
      .parameter("draco", file_options.draco, "Compress the mesh with Draco, for distribution")
      .parameter("position_bits", file_options.position_bits, {0, 30}, "bits",
                 "With draco: quantise positions to 8 to 30 bits an axis; 0 keeps them exact")
      .parameter("normal_bits", file_options.normal_bits, {0, 30}, "bits",
                 "With draco: quantise normals to 6 to 30 bits an axis; 0 keeps them exact");

  return tool.run(argc, argv, [&](stage::Run& run) {
    packing::checkOptions(file_options);
    options.precision = formats::precisionNamed(precision);
    const formats::TensorFile transfer = formats::readSafetensors(transfer_path);
    std::optional<formats::TensorFile> brdf;
    if (!brdf_path.empty()) brdf = formats::readSafetensors(brdf_path);
    const formats::Pack pack =
        packing::assemblePack(formats::readPly(mesh_path), transfer, brdf ? &*brdf : nullptr, options,
                              {mesh_path.string(), transfer_path.string(), brdf_path.string()});
    formats::Pack ordered = pack;
    packing::orderByMaterial(ordered);
    const formats::Bytes bytes = formats::encodePack(ordered, file_options, pack_path.string());
    formats::writeFileAtomically(pack_path, bytes);
    packing::report(pack, transfer, bytes, pack_path.string(), run);
  });
}
