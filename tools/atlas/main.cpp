#include <filesystem>
#include <nlohmann/json.hpp>

#include "formats/materials.h"
#include "formats/mesh_ply.h"
#include "tools/atlas/make_atlas.h"
#include "tools/atlas/maps/geometry_maps.h"
#include "tools/atlas/mesh_file.h"
#include "tools/atlas/options.h"
#include "tools/atlas/report.h"
#include "tools/stage/stage.h"

int main(int argc, char** argv) {
  using namespace bakelight;
  std::filesystem::path mesh_path, cuts_path, atlas_path, charts_path, maps_path;
  atlas::GivenOptions given;
  stage::Tool tool("atlas", "Divides a mesh into charts, lays them flat and packs them into a square");
  tool.input("mesh", "mesh", mesh_path, "Mesh of any format; its triangles are taken as they are")
      .input("cuts", "atlas_cuts", cuts_path, "JSON: edges that no chart crosses, and corners of polygons",
             false)
      .output("atlas", "mesh", atlas_path,
              "The mesh with texture coordinates, its vertices copied along chart borders")
      .output("charts", "tensors", charts_path,
              "Chart of each triangle, and where triangles and vertices come from", false)
      .output("maps", "image", maps_path,
              "EXR: position, normal, tangent, area, triangle, chart of each texel", false);
  atlas::declareOptions(tool, given);
  return tool.run(argc, argv, [&](stage::Run& run) {
    const atlas::MeshFile file = atlas::readMeshFile(mesh_path);
    for (const std::string& note : file.notes) run.warn(note);
    atlas::UserCuts cuts{{}, cuts_path.string(), file.marked_edges};
    if (!cuts_path.empty()) cuts.cuts = atlas::readCuts(cuts_path);
    if (given.own_texcoords && !cuts_path.empty()) run.warn("the cuts are not used, as texcoords is own");
    const atlas::AtlasOptions options = atlas::finishedOptions(given);
    const atlas::AtlasResult result = given.own_texcoords
                                          ? atlas::ownAtlas(file.mesh, options, mesh_path.string())
                                          : atlas::makeAtlas(file.mesh, cuts, options, mesh_path.string());
    formats::writePly(atlas_path, result.atlas.mesh);
    if (!charts_path.empty()) formats::writeSafetensors(charts_path, atlas::chartTables(result, options));
    if (!maps_path.empty())
      formats::writeExr(
          maps_path,
          atlas::geometryMaps(result.atlas, {options.resolution, options.border}, atlas_path.string()),
          formats::ExrPrecision::kFloat);
    for (const std::string& warning : result.report.warnings) run.warn(warning);
    const formats::Json stats = atlas::toJson(result.report);
    for (const auto& [name, value] : stats.items()) run.stat(name, value);
    run.stat("materials", formats::usedMaterials(result.atlas.mesh));
  });
}
