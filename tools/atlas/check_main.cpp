// atlas_check: whether a mesh's texture coordinates are an atlas, and how good a one.
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "tools/atlas/check_report.h"
#include "tools/atlas/mesh_file.h"
#include "tools/stage/stage.h"

using namespace bakelight;

int main(int argc, char** argv) {
  std::filesystem::path mesh_path;
  int resolution = 1024, gutter = 2;
  bool require_valid = false;

  stage::Tool tool("atlas_check", "Judges the texture coordinates of a mesh as an atlas.");
  tool.input("mesh", "mesh", mesh_path, "Mesh of any format")
      .parameter("resolution", resolution, {1, 16384}, "texels",
                 "Side of the square that charts are drawn to")
      .parameter("gutter", gutter, {0, 64}, "texels", "Free ones that should lie between any two charts")
      .parameter("require_valid", require_valid, "Fail if there is a defect or a gutter is too small");

  return tool.run(argc, argv, [&](stage::Run& run) {
    const atlas::CheckReport report =
        atlas::reportOf(atlas::readMeshFile(mesh_path).mesh, resolution, gutter, mesh_path.string());
    for (const auto& [name, value] : report.figures) run.stat(name, value);
    std::cout << atlas::asText(report);
    if (require_valid && !report.isValid())
      throw badInput({mesh_path.string(), "", ""},
                     "its texture coordinates are no valid atlas: " + std::to_string(report.defects) +
                         " defects, and gutters " + std::to_string(report.gutter_shortfall) + " texels short",
                     "no defects, and gutters of " + std::to_string(gutter) + " texels",
                     "make an atlas with the tool atlas");
  });
}
