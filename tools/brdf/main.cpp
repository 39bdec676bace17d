// brdf: an isotropic BRDF as a table of spherical harmonics, for pack --reflection table.
#include <algorithm>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <variant>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/material.h"
#include "tools/brdf/brdf.h"
#include "tools/brdf/merl.h"
#include "tools/stage/stage.h"

using namespace bakelight;

namespace {

// What is to be projected, by the name of its material: all that reflects under "" where it is alike.
std::map<std::string, formats::Reflection> reflectionsOf(const std::filesystem::path& path) {
  const formats::Materials materials = formats::readMaterialsOrDefault(path);
  const auto reflects = [](const formats::Material& material) {
    return !std::holds_alternative<formats::Lambert>(material.reflection);
  };
  formats::Reflection common = materials.base.reflection;
  bool are_alike = true;
  for (const auto& [name, material] : materials.by_name) {
    if (!reflects(material)) continue;
    if (std::holds_alternative<formats::Lambert>(common)) common = material.reflection;
    are_alike = are_alike && material.reflection == common;
  }
  if (are_alike) return {{"", common}};
  std::map<std::string, formats::Reflection> result;
  if (reflects(materials.base)) result.emplace("", materials.base.reflection);
  for (const auto& [name, material] : materials.by_name)
    if (reflects(material)) result.emplace(name, material.reflection);
  return result;
}

// Tells what is wrong with a projection of the material `name`.
void judge(const brdf::Projection& projection, double largest_albedo, const std::string& name,
           stage::Run& run) {
  const std::string what = name.empty() ? "the BRDF" : "the BRDF of the material " + name;
  if (largest_albedo > 1 + 1e-6)
    run.warn(what + " reflects more light than it receives: albedo " + std::to_string(largest_albedo));
  if (projection.residual > 1e-3)
    run.warn("the quadrature of " + what + " has not settled: coefficients moved by " +
             std::to_string(projection.residual));
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path merl_path, material_path, table_path;
  int order = 5, angles = 32;

  stage::Tool tool("brdf", "Projects an isotropic BRDF times the cosine of light into spherical harmonics.");
  tool.input("material", "material", material_path, "Whose reflection is projected, without the diffuse part",
             {.required = false, .parts = {"reflection"}})
      .input("merl", "brdf", merl_path, "Instead: a .binary file of the MERL database, all of it", false)
      .output("table", "tensors", table_path,
              "safetensors file with the tensor \"brdf\", or one for each material that reflects")
      .parameter("order", order, {1, 10}, "SH bands", "Order of the table, at least that of the pack's rows")
      .parameter("angles", angles, {2, 1024}, "", "Angles of the eye, in equal steps of the cosine");
  for (const char* was : {"model", "diffuse_color", "specular_color", "roughness", "exponent"})
    tool.retired(was,
                 R"(--material FILE, with { "reflection": { "model": "ggx", "roughness": 0.4 } } in it)");

  return tool.run(argc, argv, [&](stage::Run& run) {
    if (!material_path.empty() && !merl_path.empty())
      throw badInput({merl_path.string(), "", ""}, "a material is given as well", "one of the two");
    std::map<std::string, formats::BrdfTable> tables;
    double largest_albedo = 0, residual = 0;
    for (const auto& [name, reflection] : reflectionsOf(material_path)) {
      if (const auto* table = std::get_if<formats::TableReflection>(&reflection)) {
        tables[name] = table->table;
        continue;
      }
      const auto* ggx = std::get_if<formats::GgxReflection>(&reflection);
      if (ggx != nullptr && ggx->roughness < brdf::kSmallestRoughness)
        run.warn("the roughness " + std::to_string(ggx->roughness) + " is projected as " +
                 std::to_string(brdf::kSmallestRoughness) + ": so few bands cannot show the difference");
      const brdf::Brdf source = merl_path.empty()
                                    ? brdf::reflection(reflection)
                                    : brdf::readMerl(formats::readFile(merl_path), merl_path.string());
      brdf::Projection projection = brdf::project(source, order, angles);
      double albedo = 0;
      for (const transport::Vec3& color : projection.albedo) albedo = std::max(albedo, color.maxCoeff());
      judge(projection, albedo, name, run);
      largest_albedo = std::max(largest_albedo, albedo);
      residual = std::max(residual, projection.residual);
      tables[name] = std::move(projection.table);
    }
    for (const auto& [name, table] : tables)
      if (table.order != tables.begin()->second.order)
        throw badInput({material_path.string(), "", "/materials"},
                       "the table of " + name + " has the order " + std::to_string(table.order),
                       std::to_string(tables.begin()->second.order) + ", that of the others",
                       "set order to that of the tables");
    formats::writeSafetensors(table_path, brdf::tensorFile(tables));
    run.stat("tables", tables.size());
    run.stat("largest_albedo", largest_albedo);
    run.stat("quadrature_residual", residual);
  });
}
