#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "formats/json.h"
#include "formats/material.h"
#include "formats/materials.h"
#include "formats/meso_mesh.h"
#include "formats/radiance_transfer_texture.h"
#include "tools/mesomesh/field/direction_field.h"
#include "tools/mesomesh/mesh_file.h"
#include "tools/mesomesh/patches.h"
#include "tools/mesomesh/report.h"
#include "tools/mesomesh/retile/retile.h"
#include "tools/stage/stage.h"
#include "transport/ray_scene.h"

int main(int argc, char** argv) {
  using namespace bakelight;
  std::filesystem::path mesh_path, material_path, hints_path, rtt_path, meso_mesh_path, singularities_path;
  mesomesh::RetileOptions options;
  int vertices = static_cast<int>(options.vertices);
  std::string symmetry = "auto", method = "coherent";
  mesomesh::SynthesisOptions synthesis;
  int seed = 0;
  stage::Tool tool("mesomesh", "Covers a mesh with a dense, even one that a texture is laid out on");
  tool.input("mesh", "mesh", mesh_path, "Mesh of any format; each of its materials stays")
      .input("material", "material", material_path,
             "Each material's \"patch\" is laid out over its faces; without any, the mesh stays plain",
             {.required = false, .parts = {"albedo", "patch"}})
      .input("hints", "direction_hints", hints_path,
             "JSON: list of {\"point\": [x, y, z], \"direction\": [x, y, z]} that the texture's u follows",
             false)
      .input("rtt", "rtt", rtt_path, "What rtt made of the materials: exemplars of patches without a picture",
             false)
      .output("meso_mesh", "meso_mesh", meso_mesh_path,
              "PLY: even triangles with normals, tangents, places on the exemplar, materials")
      .output("singularities", "json", singularities_path,
              "Where the tangents turn about a point, and how often", false)
      .parameter("vertices", vertices, {1, 1e8}, "vertices", "Of the result, to within 5%")
      .parameter("crease_angle_deg", options.crease_angle_deg, {0, 180}, "deg",
                 "Edges sharper than this keep their place and part normals and tangents")
      .parameter(
          "symmetry", symmetry, {"auto", "1", "2", "4"},
          "The texture looks the same turned by 360 degrees over this; auto: as is measured of the patches")
      .parameter("method", method, {"coherent", "full"},
                 "full: every place of the patch is tried at every vertex; slow, for small meshes")
      .parameter("seed", seed, {0, 1e9}, "", "Another layout of the same patch")
      .parameter("randomness", synthesis.randomness, {0, 1}, "",
                 "0: the patch is tiled wherever the surface admits it");
  tool.executionPath(transport::RayScene::executionPath);  // places are found with Embree, too
  return tool.run(argc, argv, [&](stage::Run& run) {
    options.vertices = vertices;
    const mesomesh::MeshFile file = mesomesh::readMeshFile(mesh_path);
    for (const std::string& note : file.notes) run.warn(note);
    std::vector<mesomesh::DirectionHint> hints;
    if (!hints_path.empty()) hints = mesomesh::readHints(hints_path);
    mesomesh::RetiledMesh retiled = mesomesh::retile(file.mesh, options, mesh_path.string());
    for (const std::string& warning : retiled.report.warnings) run.warn(warning);
    const formats::Materials materials = formats::readMaterialsOrDefault(material_path);
    std::vector<formats::RadianceTransferTexture> transfer;
    if (!rtt_path.empty()) transfer = formats::readRadianceTransferTextures(rtt_path);
    const mesomesh::Patches patches =
        mesomesh::readPatches(materials, retiled.mesh.material_names, material_path.string(), transfer);
    const bool has_patches = mesomesh::hasPatches(materials);
    const int folds = symmetry != "auto" ? std::stoi(symmetry) : has_patches ? patches.folds() : 1;
    const mesomesh::DirectionField field =
        mesomesh::directionField(retiled.mesh, {folds, options.crease_angle_deg}, hints, hints_path.string());
    for (const std::string& warning : field.warnings) run.warn(warning);
    if (!singularities_path.empty())
      formats::writeJson(singularities_path, mesomesh::singularityTable(retiled.mesh, field, folds));
    formats::MesoMesh meso{std::move(retiled.mesh), field.tangents, {}, std::move(retiled.materials), folds};
    if (has_patches) {
      synthesis.method =
          method == "full" ? mesomesh::SynthesisMethod::kFull : mesomesh::SynthesisMethod::kCoherent;
      synthesis.folds = static_cast<mesomesh::FieldFolds>(folds);
      synthesis.seed = static_cast<std::uint64_t>(seed);
      mesomesh::layOut(patches, synthesis, mesh_path.string(), meso, run);
    } else {
      meso.patch.assign(meso.mesh.vertexCount(), {0, 0});
    }
    formats::writeMesoMesh(meso_mesh_path, meso);
    const formats::Json stats = mesomesh::toJson(retiled.report, field);
    for (const auto& [name, value] : stats.items()) run.stat(name, value);
    run.stat("materials", formats::usedMaterials(meso.mesh));
  });
}
