#include <filesystem>
#include <nlohmann/json.hpp>

#include "formats/mesh_import.h"
#include "formats/mesh_ply.h"
#include "tools/simplify/colors.h"
#include "tools/simplify/double_sided.h"
#include "tools/simplify/orientation.h"
#include "tools/simplify/report.h"
#include "tools/simplify/simplify.h"
#include "tools/stage/stage.h"
#include "transport/ray_scene.h"

int main(int argc, char** argv) {
  using namespace bakelight;
  std::filesystem::path mesh_path, texture_path, simplified_path;
  simplify::SimplifyOptions options;
  simplify::UpAxis up_axis = simplify::UpAxis::kY;
  bool double_sided = false;
  stage::Tool tool("simplify", "Repairs a mesh and reduces it to a given number of round triangles");
  tool.input("mesh", "mesh", mesh_path, "OBJ, PLY, STL, OFF, glTF, FBX, COLLADA or 3DS")
      .input("texture", "image", texture_path,
             "Albedo for the mesh's texture coordinates, in place of its own textures and colours; 8-bit "
             "images are sRGB. Becomes vertex colours",
             false)
      .output("simplified", "mesh", simplified_path,
              "Binary PLY with normals, with albedo, materials and texture coordinates if there are any")
      .parameter("up_axis", up_axis, simplify::kUpAxes,
                 "Axis of the mesh, as the importer delivers it, that is up and becomes +Y")
      .changesObject()
      .parameter("triangles", options.triangles, {4, 1e8}, "triangles",
                 "Target; a mesh that has no more is repaired but not decimated")
      .parameter("refine", options.refine,
                 "Give a mesh that has fewer that many, too: for what is kept at vertices, not for its shape")
      .parameter("least_part", options.least_part, {0, 1}, "",
                 "Parts that have less of the area are left out, such as lids inside a body; 0 keeps all")
      .parameter("weld_tolerance", options.weld_tolerance, {0, 0.01}, "",
                 "Vertices this close, over the bounding-box diagonal, become one; 0: only coincident ones")
      .parameter("crease_angle_deg", options.crease_angle_deg, {0, 180}, "deg",
                 "Edges sharper than this are kept in place and shaded flat")
      .parameter("relax_rounds", options.relax_rounds, {0, 100}, "rounds",
                 "Edge flips and vertex moves for rounder triangles; 0 leaves decimation's triangles")
      .parameter(
          "double_sided", double_sided,
          "Give parts with an open border a back of their own, so that it is lit as such; doubles them")
      .changesObject();
  tool.executionPath(transport::RayScene::executionPath);  // distances are measured with Embree, too
  return tool.run(argc, argv, [&](stage::Run& run) {
    formats::MeshImport imported = formats::importMesh(mesh_path);
    for (const std::string& note : imported.notes) run.warn(note);
    if (!texture_path.empty()) {
      for (const std::string& note : simplify::replaceAlbedo(imported, texture_path, mesh_path.string()))
        run.warn(note);
    }
    simplify::turnUpright(imported.mesh, up_axis);
    simplify::SimplifyResult result = simplify::simplify(imported.mesh, options, mesh_path.string());
    simplify::CarriedAlbedo albedo = simplify::carryAlbedo(imported, result.mesh, mesh_path.string());
    for (const std::string& note : albedo.notes) run.warn(note);
    result.mesh.colors = std::move(albedo.colors);
    if (double_sided) run.stat("back_triangles", simplify::addBacks(result.mesh));
    formats::writePly(simplified_path, result.mesh);
    for (const std::string& warning : result.report.warnings) run.warn(warning);
    const formats::Json stats = simplify::toJson(result.report);
    for (const auto& [name, value] : stats.items()) run.stat(name, value);
  });
}
