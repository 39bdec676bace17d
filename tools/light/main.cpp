// light: a light rig as spherical harmonics, with a picture of it.
#include <filesystem>

#include "formats/light_rig_file.h"
#include "tools/light/light.h"
#include "tools/stage/stage.h"

using namespace bakelight;

int main(int argc, char** argv) {
  std::filesystem::path rig_path, light_path, preview_path;
  int order = 5;

  stage::Tool tool("light", "Turns a light rig into spherical-harmonic coefficients, windowed as it says.");
  tool.input("rig", "light_rig", rig_path, "JSON file of lights, see docs/LIGHTS.md")
      .output("light", "tensors", light_path, "safetensors file with the tensor \"light\", order² × RGB",
              false)
      .output("preview", "image", preview_path,
              "EXR: the lights as a lat-long image above what the coefficients make of them", false)
      .parameter("order", order, {1, 10}, "SH bands", "Order of the light");

  return tool.run(argc, argv, [&](stage::Run& run) {
    const formats::LightRig rig = formats::readLightRig(rig_path);
    for (const std::string& note : formats::notesOn(rig)) run.warn(note);
    const transport::RigLight light = transport::distantLight(rig, order);
    if (!light_path.empty()) formats::writeSafetensors(light_path, light::tensorFile(light, order));
    if (!preview_path.empty())
      formats::writeExr(preview_path, light::preview(light, order), formats::ExrPrecision::kFloat);
    light::report(light, light::figuresOf(rig, light.light), rig, run);
  });
}
