// dilate: fills what lies between the charts of a texture.
#include <filesystem>

#include "formats/error.h"
#include "tools/dilate/dilate.h"
#include "tools/stage/stage.h"

using namespace bakelight;

int main(int argc, char** argv) {
  std::filesystem::path image_path, maps_path, output_path;
  dilate::DilateOptions options;

  stage::Tool tool("dilate", "Fills the texels of a texture that no chart covers.");
  tool.input("image", "image", image_path, "Texture, with any channels")
      .input("maps", "image", maps_path,
             "Geometry maps of its atlas; what their channel \"coverage\" has 0 is filled")
      .output("dilated", "image", output_path, "EXR of the same channels, 32-bit floats")
      .parameter("method", options.method, dilate::kMethods,
                 "nearest: copies of texels, for indices, too; push_pull: smooth averages")
      .parameter("reach", options.reach, {0, 16384}, "texels",
                 "How far to fill from what is covered; 0: everything");

  return tool.run(argc, argv, [&](stage::Run& run) {
    const auto sizeOf = [](const formats::Image& image) {
      return std::to_string(image.width) + " × " + std::to_string(image.height) + " texels";
    };
    formats::Image image = formats::readImage(image_path);
    const formats::Image maps = formats::readImage(maps_path);
    if (image.width != maps.width || image.height != maps.height)
      throw badInput({image_path.string(), "", ""}, "it has " + sizeOf(image),
                     sizeOf(maps) + ", as the maps have", "make both at one resolution");
    const dilate::Dilation result =
        dilate::dilated(std::move(image), dilate::coveredTexels(maps, maps_path.string()), options);
    formats::writeExr(output_path, result.image, formats::ExrPrecision::kFloat);
    run.stat("filled_texels", result.filled);
  });
}
