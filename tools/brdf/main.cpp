// brdf: an isotropic BRDF as a table of spherical harmonics, for pack --reflection table.
#include <filesystem>
#include <variant>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/material.h"
#include "tools/brdf/brdf.h"
#include "tools/brdf/merl.h"
#include "tools/stage/stage.h"

using namespace bakelight;

namespace {

// Of materials that reflect at all: what they have alike.
formats::Reflection reflectionOf(const std::filesystem::path& path) {
  const formats::Materials materials = formats::readMaterialsOrDefault(path);
  formats::Reflection common = materials.base.reflection;
  for (const auto& [name, material] : materials.by_name) {
    if (std::holds_alternative<formats::Lambert>(material.reflection)) continue;
    if (!std::holds_alternative<formats::Lambert>(common) && material.reflection != common)
      throw badInput({path.string(), "", formats::childPointer("/materials", name) + "/reflection"},
                     "the materials reflect differently", "one reflection; albedos may differ");
    common = material.reflection;
  }
  return common;
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path merl_path, material_path, table_path;
  int order = 5, angles = 32;

  stage::Tool tool("brdf", "Projects an isotropic BRDF times the cosine of light into spherical harmonics.");
  tool.input("material", "material", material_path, "Whose reflection is projected, without the diffuse part",
             {.required = false, .parts = {"reflection"}})
      .input("merl", "brdf", merl_path, "Instead: a .binary file of the MERL database, all of it", false)
      .output("table", "tensors", table_path, "safetensors file with the tensor \"brdf\"")
      .parameter("order", order, {1, 10}, "SH bands", "Order of the table, at least that of the pack's rows")
      .parameter("angles", angles, {2, 1024}, "", "Angles of the eye, in equal steps of the cosine");
  for (const char* was : {"model", "diffuse_color", "specular_color", "roughness", "exponent"})
    tool.retired(was,
                 R"(--material FILE, with { "reflection": { "model": "ggx", "roughness": 0.4 } } in it)");

  return tool.run(argc, argv, [&](stage::Run& run) {
    if (!material_path.empty() && !merl_path.empty())
      throw badInput({merl_path.string(), "", ""}, "a material is given as well", "one of the two");
    const formats::Reflection reflection = reflectionOf(material_path);
    if (const auto* table = std::get_if<formats::TableReflection>(&reflection))
      return formats::writeSafetensors(table_path, brdf::tensorFile(table->table));
    const brdf::Brdf source = merl_path.empty()
                                  ? brdf::reflection(reflection)
                                  : brdf::readMerl(formats::readFile(merl_path), merl_path.string());
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
