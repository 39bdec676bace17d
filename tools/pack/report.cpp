#include "tools/pack/report.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <variant>

#include "formats/pixel_transfer.h"
#include "tools/pack/packing.h"

namespace bakelight::packing {
namespace {

// Of the vertices' own albedo.
formats::Float3 largestColor(const formats::Pack& pack) {
  if (pack.colors.empty()) return {1, 1, 1};
  formats::Float3 largest{};
  for (const formats::Float3& color : pack.colors)
    for (std::size_t c = 0; c < 3; ++c) largest[c] = std::max(largest[c], color[c]);
  return largest;
}

bool reflectsTooMuch(const formats::Pack& pack) {
  constexpr float kRounding = 1e-6F;
  const formats::Float3 largest = largestColor(pack);
  for (const formats::Appearance& appearance : pack.appearances) {
    const auto* phong = appearance.reflection.as<formats::PhongLobe>();
    const auto* ggx = appearance.reflection.as<formats::GgxLobe>();
    if (phong == nullptr && ggx == nullptr) continue;
    const formats::Float3& specular = phong != nullptr ? phong->specular_color : ggx->specular_color;
    for (std::size_t c = 0; c < 3; ++c)
      if (largest[c] * appearance.base_color[c] + specular[c] > 1 + kRounding) return true;
  }
  return false;
}

bool lobeLeavesOut(const formats::SurfaceMaterials& material) {
  return std::any_of(material.reflections.begin(), material.reflections.end(), [](const auto& reflection) {
    const auto* ggx = std::get_if<formats::GgxReflection>(&reflection);
    return ggx != nullptr && (ggx->fresnel || ggx->multiple_scattering);
  });
}

const char* pixelStorage(const formats::Pack& pack) {
  const auto* pixel = pack.transfer.as<formats::PixelTransfer>();
  return pixel != nullptr && pixel->sums ? "sums" : "csr";
}

}  // namespace

void warnOfLobe(const formats::Pack& pack, const formats::SurfaceMaterials& material, stage::Run& run) {
  const bool has_lobe = std::any_of(pack.appearances.begin(), pack.appearances.end(),
                                    [](const formats::Appearance& appearance) {
                                      return appearance.reflection.as<formats::GgxLobe>() != nullptr;
                                    });
  if (has_lobe && lobeLeavesOut(material))
    run.warn(
        "a lobe has neither Fresnel's term nor multiple scattering, which the material has; reflection "
        "table has both");
}

void report(const formats::Pack& pack, const formats::TensorFile& transfer, std::span<const std::byte> bytes,
            const std::string& file, stage::Run& run) {
  // Of the file: Draco splits and drops vertices.
  const formats::Pack written = formats::decodePack(bytes, file);
  const auto vertices = static_cast<double>(written.mesh.vertexCount());
  run.stat("vertices", written.mesh.vertexCount());
  run.stat("triangles", written.mesh.triangleCount());
  run.stat("bytes", bytes.size());
  std::map<std::string, double> sizes;
  for (const formats::PackSection& section : formats::packSections(bytes, file)) {
    double& bytes_per_vertex = sizes[section.name];  // primitives have sections of the same name
    bytes_per_vertex += static_cast<double>(section.size_bytes) / vertices;
  }
  run.stat("bytes_per_vertex", sizes);
  const auto* sh = pack.transfer.as<formats::ShTransfer>();
  const bool is_glossy = sh != nullptr && sh->glossy.has_value();
  run.stat("storage", is_glossy ? sh->glossy->operatorName() : sh != nullptr ? "none" : pixelStorage(pack));
  run.stat("materials", written.appearances.size());
  run.stat("albedo_source", pack.colors.empty() ? "material" : "vertices");
  if (const auto* pixel = pack.transfer.as<formats::PixelTransfer>(); pixel != nullptr && pixel->changes) {
    run.stat("tolerance", pixel->changes->tolerance);
    run.stat("largest_error", pixel->changes->largest_error);
    run.stat("rms_error", pixel->changes->rms_error);
  }
  if (is_glossy) run.stat("precision_error", precisionErrors(pack, transfer));
  if (reflectsTooMuch(pack)) {
    run.warn("albedo and specular_color add up to more than 1: the object reflects more light than it gets");
  }
}

}  // namespace bakelight::packing
