// survey: measures what light transport a mesh needs, for recipes that leave out what it does not.
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/mesh_ply.h"
#include "tools/stage/stage.h"
#include "tools/survey/survey.h"
#include "transport/ray_scene.h"

using namespace bakelight;

int main(int argc, char** argv) {
  using Lobe = survey::SurveyOptions::Lobe;
  const std::map<std::string, Lobe> lobes = {
      {"none", Lobe::kNone}, {"phong", Lobe::kTinted}, {"ggx", Lobe::kTinted}, {"table", Lobe::kTable}};
  std::filesystem::path mesh_path;
  survey::SurveyOptions options;
  std::string lobe = "none";

  stage::Tool tool("survey", "Measures what light transport a mesh needs, before any is baked.");
  tool.input("mesh", "mesh", mesh_path, "PLY mesh, as simplify writes it; its colours are the albedo")
      .parameter("albedo", options.albedo, {0, 1}, "",
                 "Diffuse reflectance where the mesh has no colours, linear red, green and blue")
      .parameter("lobe", lobe, {"none", "phong", "ggx", "table"},
                 "Glossy reflection that is planned; a table counts as all glossy")
      .parameter("specular_color", options.specular_color, {0, 1}, "",
                 "With lobe phong or ggx: its reflectance, linear red, green and blue")
      .parameter("samples", options.samples, {64, 1e8}, "points",
                 "On the surface, where the figures are sampled; standard errors fall with the square root");

  tool.executionPath(transport::RayScene::executionPath);

  return tool.run(argc, argv, [&](stage::Run& run) {
    options.lobe = lobes.at(lobe);
    const formats::TriangleMesh mesh = formats::readPly(mesh_path);
    transport::requireTraceableScale(mesh, mesh_path.string());
    survey::Survey result;
    try {
      result = survey::survey(mesh, options);
    } catch (const std::invalid_argument& error) {
      throw badInput({mesh_path.string(), "", ""}, error.what(), "a surface", "look at the mesh");
    }
    const auto estimate = [&](const std::string& name, const survey::Estimate& figure) {
      run.stat(name, figure.value);
      run.stat(name + "_standard_error", figure.standard_error);
    };
    run.stat("concavity", result.concavity);
    estimate("blocked_share", result.blocked_share);
    run.stat("largest_blocked_share", result.largest_blocked_share);
    estimate("bounce_energy", result.bounce_energy);
    estimate("view_dependence", result.view_dependence);
    run.stat("rays", result.rays);
  });
}
