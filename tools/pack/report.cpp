#include "tools/pack/report.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <variant>

#include "tools/pack/packing.h"

namespace bakelight::packing {
namespace {

formats::Float3 largestAlbedo(const formats::Pack& pack) {
  if (pack.colors.empty()) return pack.base_color;
  formats::Float3 largest{};
  for (const formats::Float3& color : pack.colors) {
    for (std::size_t c = 0; c < 3; ++c) largest[c] = std::max(largest[c], color[c] * pack.base_color[c]);
  }
  return largest;
}

bool reflectsTooMuch(const formats::Pack& pack) {
  const formats::GlossyMaterial& material = pack.transfer.material;
  if (material.model != formats::LobeModel::kPhong && material.model != formats::LobeModel::kGgx)
    return false;
  constexpr float kRounding = 1e-6F;
  const formats::Float3 albedo = largestAlbedo(pack);
  for (std::size_t c = 0; c < 3; ++c) {
    if (albedo[c] + material.specular_color[c] > 1 + kRounding) return true;
  }
  return false;
}

bool lobeLeavesOut(const formats::SurfaceMaterials& material) {
  return std::any_of(material.reflections.begin(), material.reflections.end(), [](const auto& reflection) {
    const auto* ggx = std::get_if<formats::GgxReflection>(&reflection);
    return ggx != nullptr && (ggx->fresnel || ggx->multiple_scattering);
  });
}

}  // namespace

void warnOfLobe(const formats::Pack& pack, const formats::SurfaceMaterials& material, stage::Run& run) {
  if (pack.transfer.material.model == formats::LobeModel::kGgx && lobeLeavesOut(material))
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
  formats::Json per_vertex = formats::Json::object();
  for (const formats::PackSection& section : formats::packSections(bytes, file)) {
    per_vertex[section.name] = static_cast<double>(section.size_bytes) / vertices;
  }
  run.stat("bytes_per_vertex", std::move(per_vertex));
  run.stat("storage", nameOf(pack.transfer.storage));
  run.stat("albedo_source", pack.colors.empty() ? "material" : "vertices");
  if (pack.transfer.storage != formats::MatrixStorage::kNone) {
    run.stat("precision_error", precisionErrors(pack, transfer));
  }
  if (reflectsTooMuch(pack)) {
    run.warn("albedo and specular_color add up to more than 1: the object reflects more light than it gets");
  }
}

}  // namespace bakelight::packing
