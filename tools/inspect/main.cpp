#include <iostream>

#include "formats/image.h"
#include "tools/inspect/inspect.h"
#include "tools/stage/stage.h"

using namespace bakelight;

namespace {

constexpr formats::Word<bool> kFormats[] = {{"text", false}, {"json", true}};

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path file_path, preview_path;
  inspect::PreviewOptions options;
  inspect::PatchFiles patch;
  bool as_json = false;

  stage::Tool tool("inspect",
                   "Says what is in a mesh, image, tensor file, pack, BTF or record, and draws it.");
  tool.input("file", "any", file_path, "File to look into")
      .input("id_map", "id_map", patch.id_map,
             "For a mesh's preview: what its texture coordinates show of a patch", false)
      .input("exemplar", "image", patch.exemplar, "With an id map: the patch, in its colours", false)
      .output("preview", "image", preview_path, "PNG picture of the content", false)
      .parameter("format", as_json, kFormats, "How to print the summary")
      .parameter("size", options.size_px, {16, 8192}, "px", "Longer side of the preview")
      .parameter("yaw_deg", options.yaw_deg, {-360, 360}, "deg", "Camera angle around +Y, 0 stands at +Z")
      .parameter("pitch_deg", options.pitch_deg, {-89, 89}, "deg", "Camera angle above the horizon")
      .parameter("paint", options.paint, inspect::kPaints,
                 "Of a mesh's or pack's preview: a colour for each chart or material, how much texture "
                 "triangles have, colours of vertices; of a meso-mesh's: its places in the patch, "
                 "directions, or where neighbours continue each other")
      .parameter("layout", options.layout, inspect::kLayouts,
                 "Of a mesh's or pack's preview: the model, or its texture coordinates in the unit square");

  return tool.run(argc, argv, [&](stage::Run& run) {
    const bool draws = !preview_path.empty();
    const inspect::Inspection inspection =
        inspect::inspectFile(file_path, draws ? std::optional(options) : std::nullopt, patch);
    if (draws) formats::writePng(preview_path, inspection.preview->image);
    // Of a stage that draws, the driver wants the picture: its log is not for summaries.
    if (draws && run.progressStyle() == stage::ProgressStyle::kJson) return;
    std::cout << (as_json ? inspect::asJson(inspection.summary).dump(2) + "\n"
                          : inspect::asText(inspection.summary));
  });
}
