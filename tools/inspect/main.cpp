#include <iostream>

#include "formats/image.h"
#include "tools/inspect/inspect.h"
#include "tools/stage/stage.h"

using namespace bakelight;

int main(int argc, char** argv) {
  std::filesystem::path file_path, preview_path;
  inspect::PreviewOptions options;
  inspect::PatchFiles patch;
  std::string format = "text", paint = inspect::paintNames().front(), layout = inspect::layoutNames().front();

  stage::Tool tool("inspect", "Says what is in a mesh, image, tensor file, pack or record, and draws it.");
  tool.input("file", "any", file_path, "File to look into")
      .input("id_map", "id_map", patch.id_map,
             "For a mesh's preview: what its texture coordinates show of a patch", false)
      .input("exemplar", "image", patch.exemplar, "With an id map: the patch, in its colours", false)
      .output("preview", "image", preview_path, "PNG picture of the content", false)
      .parameter("format", format, {"text", "json"}, "How to print the summary")
      .parameter("size", options.size_px, {16, 8192}, "px", "Longer side of the preview")
      .parameter("yaw_deg", options.yaw_deg, {-360, 360}, "deg", "Camera angle around +Y, 0 stands at +Z")
      .parameter("pitch_deg", options.pitch_deg, {-89, 89}, "deg", "Camera angle above the horizon")
      .parameter("paint", paint, inspect::paintNames(),
                 "Of a mesh's or pack's preview: a colour for each chart or material, how much texture "
                 "triangles have, colours of vertices; of a meso-mesh's: its places in the patch, "
                 "directions, or where neighbours continue each other")
      .parameter("layout", layout, inspect::layoutNames(),
                 "Of a mesh's or pack's preview: the model, or its texture coordinates in the unit square");

  return tool.run(argc, argv, [&](stage::Run& run) {
    options.paint = inspect::paintOf(paint);
    options.layout = inspect::layoutOf(layout);
    const bool draws = !preview_path.empty();
    const inspect::Inspection inspection =
        inspect::inspectFile(file_path, draws ? std::optional(options) : std::nullopt, patch);
    if (draws) formats::writePng(preview_path, inspection.preview->image);
    // Of a stage that draws, the driver wants the picture: its log is not for summaries.
    if (draws && run.progressStyle() == stage::ProgressStyle::kJson) return;
    std::cout << (format == "json" ? inspect::asJson(inspection.summary).dump(2) + "\n"
                                   : inspect::asText(inspection.summary));
  });
}
