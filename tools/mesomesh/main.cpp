#include <filesystem>
#include <nlohmann/json.hpp>

#include "formats/mesh_import.h"
#include "formats/mesh_ply.h"
#include "tools/mesomesh/retile/retile.h"
#include "tools/stage/stage.h"

int main(int argc, char** argv) {
  using namespace bakelight;
  std::filesystem::path mesh_path, out_path;
  int vertices = 960000;
  mesomesh::RetileOptions options;
  stage::Tool tool("mesomesh", "Covers a mesh with a dense even one");
  tool.input("mesh", "mesh", mesh_path, "Mesh of any format")
      .output("meso_mesh", "mesh", out_path, "mesh")
      .parameter("vertices", vertices, {1, 1e8}, "", "Target")
      .parameter("crease_angle_deg", options.crease_angle_deg, {0, 180}, "deg", "x");
  return tool.run(argc, argv, [&](stage::Run& run) {
    options.vertices = vertices;
    mesomesh::RetiledMesh m =
        mesomesh::retile(formats::importMesh(mesh_path).mesh, options, mesh_path.string());
    formats::writePly(out_path, m.mesh);
    for (auto& w : m.report.warnings) run.warn(w);
    auto& r = m.report;
    std::printf(
        "v %ld t %ld copies %ld comps %ld coarse %ld d %d L %g q %g min %g six %g folded %ld dev %g mean %g "
        "creases %ld\n",
        r.vertices, r.triangles, r.crease_copies, r.components, r.coarse_vertices, r.subdivisions,
        r.edge_length, r.mean_quality, r.least_quality, r.six_neighbors, r.folded_triangles,
        r.largest_deviation, r.mean_deviation, r.crease_edges);
    for (auto& [k, s] : r.seconds) std::printf("%s %.2f  ", k.c_str(), s);
    std::printf("\n");
  });
}
