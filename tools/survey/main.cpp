// survey: measures what light transport a mesh needs, for recipes that leave out what it does not.
#include <filesystem>
#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/material.h"
#include "formats/mesh_ply.h"
#include "tools/stage/stage.h"
#include "tools/survey/survey.h"
#include "transport/ray_scene.h"

using namespace bakelight;

namespace {

constexpr const char* kAlbedoNow = R"(a material: in asset.json "material": { "albedo": [0.8, 0.8, 0.8] })";
constexpr const char* kReflectionNow =
    R"(a material: in asset.json "material": { "reflection": { "model": "ggx", "roughness": 0.3 } })";

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path mesh_path, material_path;
  int samples = survey::SurveyOptions().samples;

  stage::Tool tool("survey", "Measures what light transport a mesh needs, before any is baked.");
  tool.input("mesh", "mesh", mesh_path,
             "PLY mesh, as simplify writes it; its colours are the albedo unless material has one")
      .input("material", "material", material_path,
             "What the mesh is made of; a BRDF table counts as all glossy",
             {.required = false, .parts = {"albedo", "reflection"}})
      .parameter("samples", samples, {64, 1e8}, "points",
                 "On the surface, where the figures are sampled; standard errors fall with the square root")
      .retired("albedo", kAlbedoNow)
      .retired("lobe", kReflectionNow)
      .retired("specular_color", kReflectionNow);

  tool.executionPath(transport::RayScene::executionPath);

  return tool.run(argc, argv, [&](stage::Run& run) {
    formats::TriangleMesh mesh = formats::readPly(mesh_path);
    transport::requireTraceableScale(mesh, mesh_path.string());
    formats::SurfaceMaterials materials = formats::materialsOn(
        mesh, formats::readMaterialsOrDefault(material_path), mesh_path.string(), material_path.string());
    survey::SurveyOptions options = survey::optionsFor(materials);
    options.samples = samples;
    mesh.colors = std::move(materials.vertex_albedo);
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
