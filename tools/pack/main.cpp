#include <filesystem>
#include <nlohmann/json.hpp>

#include "formats/mesh_ply.h"
#include "formats/pack.h"
#include "formats/tensors.h"
#include "tools/pack/packing.h"
#include "tools/stage/stage.h"

using namespace bakelight;

namespace {

void report(const formats::Pack& pack, std::span<const std::byte> bytes, const std::string& file,
            stage::Run& run) {
  const auto vertices = static_cast<double>(pack.mesh.vertexCount());
  run.stat("vertices", pack.mesh.vertexCount());
  run.stat("triangles", pack.mesh.triangleCount());
  run.stat("bytes", bytes.size());
  formats::Json per_vertex = formats::Json::object();
  for (const formats::PackSection& section : formats::packSections(bytes, file)) {
    per_vertex[section.name] = static_cast<double>(section.size_bytes) / vertices;
  }
  run.stat("bytes_per_vertex", std::move(per_vertex));
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path mesh_path, transfer_path, pack_path;
  std::string name = "asset";
  formats::Float3 albedo = {0.8F, 0.8F, 0.8F};
  formats::PackOptions options;

  stage::Tool tool("pack", "Puts a mesh and its baked transfer together as one pack, a binary glTF file.");
  tool.input("mesh", "mesh", mesh_path, "PLY mesh that the transfer was baked for")
      .input("transfer", "tensors", transfer_path, "safetensors file of the transfer tool")
      .output("pack", "pack", pack_path, "binary glTF file (.glb)")
      .parameter("name", name, {}, "Name of the asset, shown by glTF viewers")
      .parameter("albedo", albedo, {0, 1}, "", "Diffuse reflectance, linear red, green and blue")
      .parameter("draco", options.draco, "Compress the mesh with Draco, for distribution")
      .parameter("position_bits", options.position_bits, {0, 30}, "bits",
                 "With draco: quantise positions to 8 to 30 bits an axis; 0 keeps them exact")
      .parameter("normal_bits", options.normal_bits, {0, 30}, "bits",
                 "With draco: quantise normals to 6 to 30 bits an axis; 0 keeps them exact");

  return tool.run(argc, argv, [&](stage::Run& run) {
    packing::checkOptions(options);
    const formats::Pack pack =
        packing::assemblePack(formats::readPly(mesh_path), formats::readSafetensors(transfer_path), name,
                              albedo, {mesh_path.string(), transfer_path.string()});
    const formats::Bytes bytes = formats::encodePack(pack, options, pack_path.string());
    formats::writeFileAtomically(pack_path, bytes);
    // What is in the file: Draco splits and drops vertices.
    report(options.draco ? formats::decodePack(bytes, pack_path.string()) : pack, bytes, pack_path.string(),
           run);
  });
}
