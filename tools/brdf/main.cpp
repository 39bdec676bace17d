// brdf: an isotropic BRDF as a table of spherical harmonics, for pack --reflection table.
#include <algorithm>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <variant>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/material.h"
#include "tools/brdf/brdf.h"
#include "tools/brdf/measured.h"
#include "tools/brdf/merl.h"
#include "tools/brdf/tensor_bsdf.h"
#include "tools/brdf/utia.h"
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

struct MeasuredFile {
  std::filesystem::path path;
  brdf::MeasuredBrdf (*read)(std::span<const std::byte> bytes, const std::string& file);
};

brdf::MeasuredBrdf readMerl(std::span<const std::byte> bytes, const std::string& file) {
  return {.brdf = brdf::readMerl(bytes, file), .notes = {}};
}

brdf::MeasuredBrdf readMeasured(const MeasuredFile& file, stage::Run& run) {
  brdf::MeasuredBrdf measured = file.read(formats::readFile(file.path), file.path.string());
  for (const std::string& note : measured.notes) run.warn(note);
  constexpr double kNoticed = 0.01;
  if (measured.anisotropy > kNoticed)
    run.warn("it is anisotropic: its mean over turns about the normal is projected, of which it differs by " +
             std::to_string(measured.anisotropy) + " (relative RMS)");
  run.stat("anisotropy", measured.anisotropy);
  return measured;
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
  std::filesystem::path material_path, table_path;
  MeasuredFile merl{{}, readMerl}, bsdf{{}, brdf::readTensorBsdf}, utia{{}, brdf::readUtia};
  int order = 5, angles = 32;

  stage::Tool tool("brdf", "Projects an isotropic BRDF times the cosine of light into spherical harmonics.");
  tool.input("material", "material", material_path, "Whose reflection is projected, without the diffuse part",
             {.required = false, .parts = {"reflection"}})
      .input("merl", "brdf", merl.path, "Instead: a .binary file of the MERL database, all of it", false)
      .input("bsdf", "brdf", bsdf.path, "Instead: a .bsdf file of the RGL database (Mitsuba)", false)
      .input("utia", "brdf", utia.path, "Instead: a .bin file of the UTIA BRDF database", false)
      .output("table", "tensors", table_path,
              "safetensors file with the tensor \"brdf\", or one for each material that reflects")
      .parameter("order", order, {1, 10}, "SH bands", "Order of the table, at least that of the pack's rows")
      .parameter("angles", angles, {2, 1024}, "", "Angles of the eye, in equal steps of the cosine");
  for (const char* was : {"model", "diffuse_color", "specular_color", "roughness", "exponent"})
    tool.retired(was,
                 R"(--material FILE, with { "reflection": { "model": "ggx", "roughness": 0.4 } } in it)");

  return tool.run(argc, argv, [&](stage::Run& run) {
    const MeasuredFile* measured = nullptr;
    for (const MeasuredFile* file : {&merl, &bsdf, &utia}) {
      if (file->path.empty()) continue;
      if (!material_path.empty() || measured != nullptr)
        throw badInput(
            {file->path.string(), "", ""},
            measured == nullptr ? "a material is given as well" : "another measured file is given as well",
            "one of the two");
      measured = file;
    }
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
      const brdf::Brdf source =
          measured == nullptr ? brdf::reflection(reflection) : readMeasured(*measured, run).brdf;
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
