// idmap: which place of its patch each texel of an atlas shows.
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "formats/materials.h"
#include "formats/mesh_ply.h"
#include "formats/meso_mesh.h"
#include "tools/idmap/frames.h"
#include "tools/idmap/idmap.h"
#include "tools/idmap/patch_widths.h"
#include "tools/idmap/triangle_materials.h"
#include "tools/stage/stage.h"

using namespace bakelight;

int main(int argc, char** argv) {
  std::filesystem::path meso_path, maps_path, atlas_path, id_map_path, frames_path;
  idmap::IdMapOptions options;

  stage::Tool tool("idmap", "Finds for each texel of an atlas the place in the patch that it shows");
  tool.input("meso_mesh", "meso_mesh", meso_path, "What mesomesh made of the surface")
      .input("maps", "image", maps_path, "Geometry maps of the atlas, made of the same surface")
      .input("atlas", "mesh", atlas_path,
             "The mesh that the maps are of: texels take vertices of their own material only", false)
      .output("id_map", "id_map", id_map_path,
              "EXR of integers: coordinate in the patch, material and meso-vertex of each texel")
      .output("frames", "tensors", frames_path,
              "Of each vertex of the atlas the tangent of its patch, for transfer", false)
      .parameter("neighbors", options.neighbors, {1, 4096}, "vertices",
                 "Of the nearest so many, the one nearest to the line along the normal is taken");

  return tool.run(argc, argv, [&](stage::Run& run) {
    const formats::MesoMesh meso = formats::readMesoMesh(meso_path);
    if (meso.mesh.vertexCount() == 0)
      throw badInput({meso_path.string(), "", ""}, "it has no vertices", "a meso-mesh with some");
    std::vector<std::uint32_t> materials;
    if (!atlas_path.empty()) {
      const formats::TriangleMesh atlas = formats::readPly(atlas_path);
      materials =
          idmap::triangleMaterials(atlas, atlas_path.string(), meso.mesh.material_names, meso_path.string());
      if (!frames_path.empty()) {
        const idmap::PatchFrames frames = idmap::patchFrames(
            atlas, meso, materials, static_cast<std::size_t>(options.neighbors), meso_path.string());
        idmap::writeFrames(frames_path, frames.tangents, atlas);
        run.stat("undetermined_frames", frames.undetermined);
        if (frames.undetermined > 0)
          run.warn(std::to_string(frames.undetermined) +
                   " vertices face no vertex of the meso-mesh: their frames follow the normal alone");
      }
    } else if (!frames_path.empty()) {
      throw badInput({"", "", "/frames"}, "frames are those of an atlas's vertices", "an input atlas");
    }
    options.triangle_materials = materials;
    stage::Progress progress = run.progress("idmap", idmap::rowsOf(maps_path), "rows");
    const idmap::IdMap map = idmap::makeIdMap({{meso.mesh, meso.materials}, meso.patch}, maps_path, options,
                                              [&](std::size_t rows) { progress.advance(rows); });
    const std::map<std::string, double> widths = idmap::patchWidths(meso);
    formats::writeIndexExr(id_map_path, map.image,
                           {{"bakelight:patch_widths", formats::Json(widths).dump()}});
    if (map.moved > 0)
      run.warn(std::to_string(map.moved) +
               " texels of charts' borders face no vertex and are copies of others");
    if (const std::string warning = idmap::warningOf(map, meso.mesh); !warning.empty()) run.warn(warning);
    run.stat("covered_texels", map.covered);
    run.stat("filled_texels", map.filled);
    run.stat("moved_texels", map.moved);
    run.stat("widened_searches", map.figures.widened);
    run.stat("other_sheets", map.figures.other_sheets);
    run.stat("mean_distance", map.figures.distance_sum / static_cast<double>(map.covered));
    run.stat("farthest_distance", map.figures.farthest);
  });
}
