// brdf: an isotropic BRDF as a table of spherical harmonics, for pack --lobe table.
#include <filesystem>

#include "formats/error.h"
#include "formats/file.h"
#include "tools/brdf/brdf.h"
#include "tools/brdf/merl.h"
#include "tools/stage/stage.h"

using namespace bakelight;

int main(int argc, char** argv) {
  std::filesystem::path merl_path, table_path;
  std::string model = "ggx";
  formats::Float3 diffuse_color = {0, 0, 0}, specular_color = {0.5f, 0.5f, 0.5f};
  double roughness = 0.4, exponent = 20;
  int order = 5, angles = 32;

  stage::Tool tool("brdf", "Projects an isotropic BRDF times the cosine of light into spherical harmonics.");
  tool.input("merl", "brdf", merl_path, "A .binary file of the MERL database, for model measured", false)
      .output("table", "tensors", table_path, "safetensors file with the tensor \"brdf\"")
      .parameter("model", model, {"ggx", "phong", "lambert", "measured"}, "What to project")
      .parameter("diffuse_color", diffuse_color, {0, 1}, "", "Albedo of the Lambertian part of any model")
      .parameter("specular_color", specular_color, {0, 1}, "",
                 "Reflectance of the lobe; at normal incidence for ggx")
      .parameter("roughness", roughness, {0.05, 1}, "", "Of ggx; alpha is its square")
      .parameter("exponent", exponent, {0, 1e6}, "", "Of phong")
      .parameter("order", order, {1, 10}, "SH bands", "Order of the table, at least that of the pack's rows")
      .parameter("angles", angles, {2, 1024}, "", "Angles of the eye, in equal steps of the cosine");

  return tool.run(argc, argv, [&](stage::Run& run) {
    if ((model == "measured") == merl_path.empty())
      throw badInput({merl_path.string(), "", "/model"},
                     "model " + model + " does not go with what merl names",
                     "a file for model measured, and none for the others", "change one of the two");
    const transport::Vec3 diffuse = transport::vec3(diffuse_color),
                          specular = transport::vec3(specular_color);
    const brdf::Brdf source = model == "measured"  ? brdf::readMerl(formats::readFile(merl_path), merl_path)
                              : model == "lambert" ? brdf::lambert(diffuse)
                              : model == "phong"   ? brdf::phong(diffuse, specular, exponent)
                                                   : brdf::ggx(diffuse, specular, roughness);
    const brdf::Projection projection = brdf::project(source, order, angles);
    formats::writeSafetensors(table_path, brdf::tensorFile(projection.table));
    double albedo = 0;
    for (const transport::Vec3& color : projection.albedo) albedo = std::max(albedo, color.maxCoeff());
    run.stat("largest_albedo", albedo);
    run.stat("quadrature_residual", projection.residual);
    if (albedo > 1 + 1e-6)
      run.warn("the BRDF reflects more light than it receives: albedo " + std::to_string(albedo));
    if (projection.residual > 1e-3)
      run.warn("the quadrature has not settled: coefficients moved by " +
               std::to_string(projection.residual));
  });
}
