#include "tools/pack/packing.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <variant>

#include "formats/error.h"
#include "formats/materials.h"
#include "formats/mesh_ply.h"
#include "tools/pack/tensor_source.h"
#include "tools/pack/transfer_reader.h"
#include "transport/texture_frames.h"

namespace bakelight::packing {
namespace {

using formats::EncodedTable;
using formats::Tensor;
using formats::TensorFile;

void requireSameMesh(const TensorSource& source, const formats::TriangleMesh& mesh,
                     const std::string& mesh_file) {
  const std::string hash = formats::geometryHash(mesh);
  if (source.text("mesh_hash") == hash) return;
  throw source.error("metadata mesh_hash", "the transfer was baked for another mesh than " + mesh_file, hash);
}

// That light was baked to bounce off the albedo that is shown, one for all or one a vertex.
void requireSameAlbedo(const TensorSource& source, std::uint64_t vertices,
                       const formats::SurfaceMaterials& material) {
  if (!source.has("albedo")) return;
  const Tensor& tensor = source.tensor("albedo", 2);
  const std::uint64_t rows = tensor.shape[0];
  if ((rows != 1 && rows != vertices) || tensor.shape[1] != 3) {
    throw source.error("tensor albedo", "its shape is " + shapeText(tensor.shape),
                       "1 × 3 or " + std::to_string(vertices) + " × 3, red, green and blue");
  }
  const auto values = tensor.as<float>();
  const auto shown = [&](std::size_t vertex, std::size_t c) {
    return material.vertex_albedo.empty() ? material.albedo[c] : material.vertex_albedo[vertex][c];
  };
  for (std::size_t vertex = 0; vertex < vertices; ++vertex)
    for (std::size_t c = 0; c < 3; ++c)
      if (values[(rows == 1 ? 0 : 3 * vertex) + c] != shown(vertex, c))
        throw source.error("tensor albedo", "the transfer was baked with another albedo than the material's",
                           "one material for both");
}

void takeAlbedo(const formats::SurfaceMaterials& material, formats::Pack& pack) {
  pack.mesh.colors.clear();  // a pack has them outside of its mesh
  for (formats::Appearance& appearance : pack.appearances)
    appearance.base_color = material.vertex_albedo.empty() ? material.albedo : formats::Float3{1, 1, 1};
  pack.colors = material.vertex_albedo;
}

formats::BrdfTable tableFor(const formats::Reflection& reflection, const std::string& material, int row_order,
                            const TensorFile* brdf, const SourceNames& files) {
  const auto* own = std::get_if<formats::TableReflection>(&reflection);
  if (brdf == nullptr && own == nullptr)
    throw badInput({"", "", "/brdf"}, "a table needs a projected BRDF", "a file of the brdf tool",
                   "give it as input brdf");
  const std::string file = own == nullptr ? files.brdf : own->file.string();
  formats::BrdfTable table = own == nullptr ? formats::brdfTableFrom(*brdf, file, material) : own->table;
  if (table.order < row_order)
    throw badInput({file, "metadata order", ""}, "it has fewer bands than the transferred radiance",
                   std::to_string(row_order) + " or more", "make it with the brdf tool of this version");
  return table;
}

formats::PackPart reflectionFor(const formats::Reflection& reflection, const std::string& material,
                                int output_order, const PackingOptions& options, const TensorFile* brdf,
                                const SourceNames& files) {
  if (options.reflection == ShownReflection::kNone || std::holds_alternative<formats::Lambert>(reflection))
    return formats::LambertReflection();
  if (options.reflection != ShownReflection::kTable &&
      !std::holds_alternative<formats::TableReflection>(reflection))
    return runtimeLobe(reflection);
  return tableFor(reflection, material, output_order, brdf, files);
}

// Of the material's name, else the asset's own.
const formats::RadianceTransferTexture* textureOf(const PatchSources& patches, const std::string& material) {
  const formats::RadianceTransferTexture* own = nullptr;
  for (const formats::RadianceTransferTexture& texture : patches.textures) {
    if (texture.material == material) return &texture;
    if (texture.material.empty()) own = &texture;
  }
  return patches.own_materials.contains(material) ? nullptr : own;
}

// Of the material's name, else the asset's own. Null if there is none.
template <class Value>
const Value* namedOrOwn(const std::map<std::string, Value>& by_material, const PatchSources& patches,
                        const std::string& material) {
  auto found = by_material.find(material);
  if (found == by_material.end() && !patches.own_materials.contains(material)) found = by_material.find("");
  return found == by_material.end() ? nullptr : &found->second;
}

std::optional<BtfSamples> btfOf(const PatchSources& patches, const std::string& material) {
  if (const auto* table = namedOrOwn(patches.tables, patches, material)) return samplesOf(*table);
  if (const auto* btf = namedOrOwn(patches.btfs, patches, material)) return samplesOf(**btf);
  return std::nullopt;
}

// Where the patch of `material`, as the mesh calls it, or else of `source`, lies.
void layOut(formats::FactoredPatch& patch, const std::string& material, const std::string& source,
            const formats::TriangleMesh& mesh, const PatchSources& patches, bool with_index,
            const SourceNames& files) {
  if (mesh.texcoords.size() != mesh.vertexCount())
    throw badInput({files.mesh, "", "/rtt"},
                   "a patch is looked up by texture coordinates, which this mesh has none of",
                   "the mesh that atlas wrote, or one with texture coordinates of its own");
  auto given = patches.widths.find(material);
  if (given == patches.widths.end()) given = patches.widths.find(source);
  const auto width = given == patches.widths.end() ? std::nullopt : std::optional(given->second);
  const transport::PatchRepeats repeats = transport::patchRepeats(mesh, width);
  patch.patch_width = static_cast<float>(patches.id_map ? width.value_or(repeats.width) : repeats.width);
  if (!patches.id_map) patch.repeats = static_cast<float>(repeats.repeats);
  if (patches.id_map && with_index) patch.index = packIndex(*patches.id_map);
}

// What a material reflects. The first patch brings the index, which serves all.
using ReflectionOf = std::function<formats::PackPart(const std::string& material,
                                                     const formats::Reflection& reflection, bool& has_index)>;

// One for each material that a triangle has; one without a name for a mesh that tells none apart.
std::vector<formats::Appearance> appearancesOf(formats::TriangleMesh& mesh, const PackingOptions& options,
                                               const ReflectionOf& reflection_of) {
  const formats::SurfaceMaterials& material = options.material;
  bool has_index = false;
  const auto reflectionAt = [&](std::size_t triangle) {
    const std::size_t index = material.of_triangle.empty() ? 0 : material.of_triangle[triangle];
    return reflection_of(material.names[index], material.reflections[index], has_index);
  };
  std::vector<formats::Appearance> appearances;
  const std::vector<std::size_t> triangles = formats::trianglesOfMaterials(mesh);
  std::vector<std::uint32_t> index_of(triangles.size());
  for (std::size_t m = 0; m < triangles.size(); ++m) {
    if (triangles[m] == 0) continue;
    const auto first = std::find(mesh.triangle_materials.begin(), mesh.triangle_materials.end(), m);
    index_of[m] = static_cast<std::uint32_t>(appearances.size());
    appearances.push_back({mesh.material_names[m],
                           {1, 1, 1},
                           reflectionAt(static_cast<std::size_t>(first - mesh.triangle_materials.begin()))});
  }
  if (appearances.empty()) appearances.push_back({"", {1, 1, 1}, reflectionAt(0)});
  if (appearances.size() == 1) {
    mesh.triangle_materials.clear();
    mesh.material_names.clear();
    return appearances;
  }
  for (std::uint32_t& index : mesh.triangle_materials) index = index_of[index];
  mesh.material_names.clear();
  for (const formats::Appearance& appearance : appearances)
    mesh.material_names.push_back(appearance.material);
  return appearances;
}

void checkCombination(const formats::Pack& pack, const SourceNames& files) {
  const bool has_reflection = std::any_of(
      pack.appearances.begin(), pack.appearances.end(), [](const formats::Appearance& appearance) {
        return appearance.reflection.as<formats::LambertReflection>() == nullptr;
      });
  const bool is_glossy = pack.sh().glossy.has_value();
  if (has_reflection && !is_glossy) {
    throw badInput({files.transfer, "", "/reflection"},
                   "a glossy reflection needs matrices, but this transfer is diffuse",
                   "a material without one, or reflection none",
                   "bake with the transfer tool's technique glossy, as the recipe glossy does");
  }
  if (!has_reflection && is_glossy) {
    throw badInput({files.transfer, "", "/reflection"},
                   "this transfer is glossy, but without a reflection its matrices would never be used",
                   "a material with a reflection",
                   "give it one, or bake with the transfer tool's technique diffuse");
  }
}

void checkBits(int bits, int least, const char* pointer) {
  if (bits == 0 || (bits >= least && bits <= 30)) return;
  throw badInput({"", "", pointer}, std::to_string(bits) + " is out of range",
                 "0 (lossless), or " + std::to_string(least) + " to 30");
}

double relativeError(const EncodedTable& table, std::span<const float> original) {
  const std::vector<float> decoded = table.decode();
  double difference = 0, reference = 0;
  for (std::size_t i = 0; i < original.size(); ++i) {
    const double value = original[i], error = decoded[i] - value;
    difference += error * error;
    reference += value * value;
  }
  return difference == 0 ? 0 : std::sqrt(difference / reference);
}

}  // namespace

formats::Json toJson(const std::vector<TextureFigures>& textures) {
  formats::Json json = formats::Json::array();
  for (const TextureFigures& texture : textures) {
    json.push_back({{"material", texture.material},
                    {"components", texture.components},
                    {"error", texture.error},
                    {"patch_width", texture.patch_width}});
    if (texture.stored_bytes == 0) continue;
    const auto ratio = [&](double bytes_per_value) {
      return bytes_per_value * static_cast<double>(texture.value_count) /
             static_cast<double>(texture.stored_bytes);
    };
    json.back().update(
        {{"components_error", texture.components_error},
         {"stored_bytes", texture.stored_bytes},
         {"storage_ratio", {{"float32", ratio(4)}, {"float16", ratio(2)}, {"uint8", ratio(1)}}}});
  }
  return json;
}

namespace {

formats::Pack assembleShPack(formats::TriangleMesh mesh, const TensorSource& source, const TensorFile* brdf,
                             const PackingOptions& options, const SourceNames& files,
                             const PatchSources& patches, std::vector<TextureFigures>& textures) {
  if (!patches.btfs.empty() || !patches.tables.empty())
    throw badInput({patches.tables.empty() ? patches.btfs.begin()->second->info().file
                                           : patches.tables.begin()->second.file,
                    "", "/btf"},
                   "the transfer beside it is in spherical harmonics, which a BTF has no use for",
                   "transfer in a pixel basis", "bake it with basis pixel, or give pack an rtt instead");
  formats::ShTransfer read = readTransfer(source, mesh.vertexCount(), options.precision);
  requireSameMesh(source, mesh, files.mesh);
  requireSameAlbedo(source, mesh.vertexCount(), options.material);
  const int output_order = read.glossy ? read.glossy->output_order : 0;
  std::vector<formats::Appearance> appearances =
      appearancesOf(mesh, options,
                    [&](const std::string& material, const formats::Reflection& reflection,
                        bool& has_index) -> formats::PackPart {
                      const auto* texture = textureOf(patches, material);
                      if (texture == nullptr)
                        return reflectionFor(reflection, material, output_order, options, brdf, files);
                      PackedRtt packed = packRtt(*texture, options.rtt, files.rtt);
                      layOut(packed.reflection, material, texture->material, mesh, patches,
                             !std::exchange(has_index, true), files);
                      textures.push_back({material, packed.reflection.components, packed.error,
                                          double{packed.reflection.patch_width}});
                      return std::move(packed.reflection);
                    });
  formats::Pack pack{options.name, std::move(mesh), {}, std::move(read), std::move(appearances)};
  takeAlbedo(options.material, pack);
  checkCombination(pack, files);
  return pack;
}

formats::Pack assemblePixelPack(formats::TriangleMesh mesh, const TensorSource& source,
                                const PackingOptions& options, const SourceNames& files,
                                const PatchSources& patches, std::vector<TextureFigures>& textures) {
  formats::PixelTransfer read = readPixelTransfer(source, mesh.vertexCount());
  read.crease_angle = static_cast<float>(options.crease_angle);
  requireSameMesh(source, mesh, files.mesh);
  std::vector<formats::Appearance> appearances = appearancesOf(
      mesh, options,
      [&](const std::string& material, const formats::Reflection& reflection,
          bool& has_index) -> formats::PackPart {
        const std::optional<BtfSamples> btf = btfOf(patches, material);
        if (!btf) {
          if (textureOf(patches, material) != nullptr)
            throw badInput({files.rtt, "material \"" + material + "\"", "/btf"},
                           "its patch is here a radiance transfer texture alone, for spherical harmonics",
                           "a BTF for transfer in a pixel basis",
                           "give pack the btfs that rtt writes beside it");
          if (options.reflection != ShownReflection::kNone &&
              !std::holds_alternative<formats::Lambert>(reflection))
            throw badInput({files.material, "material \"" + material + "\"", "/reflection"},
                           "with transfer in a pixel basis a reflection without a patch has no form",
                           "a BTF, or a diffuse material", "give it a patch, or set reflection none");
          return formats::LambertReflection();
        }
        // The texture of the same run, if it is given, knows where views see the same.
        PackedBtf packed =
            packBtf(*btf, read.local_side, options.btf, textureOf(patches, material), options.rtt);
        layOut(packed.reflection, material, "", mesh, patches, !std::exchange(has_index, true), files);
        textures.push_back({material, packed.reflection.components, double{packed.reflection.error},
                            double{packed.reflection.patch_width}, packed.components_error,
                            packed.value_count, packed.stored_bytes});
        return std::move(packed.reflection);
      });
  formats::Pack pack{options.name, std::move(mesh), {}, std::move(read), std::move(appearances)};
  takeAlbedo(options.material, pack);
  return pack;
}

}  // namespace

formats::Pack assemblePack(formats::TriangleMesh mesh, const TensorFile& transfer, const TensorFile* brdf,
                           const PackingOptions& options, const SourceNames& files,
                           const PatchSources& patches, std::vector<TextureFigures>* textures) {
  const TensorSource source(transfer, files.transfer,
                            "bake it again, for this mesh and by the transfer tool of this version");
  std::vector<TextureFigures> figures;
  formats::Pack pack = isPixelTechnique(source.text("technique"))
                           ? assemblePixelPack(std::move(mesh), source, options, files, patches, figures)
                           : assembleShPack(std::move(mesh), source, brdf, options, files, patches, figures);
  if (textures != nullptr) *textures = std::move(figures);
  return pack;
}

std::size_t orderByMaterial(formats::Pack& pack) {
  if (pack.appearances.size() == 1) return 0;
  formats::TriangleMesh& mesh = pack.mesh;
  constexpr std::uint32_t kUnplaced = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> source, materials;
  std::vector<formats::Triangle> triangles;
  std::vector<std::uint8_t> is_kept(mesh.vertexCount(), 0);
  for (std::uint32_t material = 0; material < pack.appearances.size(); ++material) {
    std::vector<std::uint8_t> is_used(mesh.vertexCount(), 0);
    for (std::size_t t = 0; t < mesh.triangleCount(); ++t)
      if (mesh.triangle_materials[t] == material)
        for (const std::uint32_t v : mesh.triangles[t]) is_used[v] = 1;
    std::vector<std::uint32_t> target(mesh.vertexCount(), kUnplaced);
    for (std::uint32_t v = 0; v < is_used.size(); ++v) {
      if (is_used[v] == 0) continue;
      is_kept[v] = 1;
      target[v] = static_cast<std::uint32_t>(source.size());
      source.push_back(v);
    }
    for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
      if (mesh.triangle_materials[t] != material) continue;
      const formats::Triangle& old = mesh.triangles[t];
      triangles.push_back({target[old[0]], target[old[1]], target[old[2]]});
      materials.push_back(material);
    }
  }
  mesh.triangles = std::move(triangles);
  mesh.triangle_materials = std::move(materials);
  formats::permuteVertices(pack, source);
  return static_cast<std::size_t>(std::count(is_kept.begin(), is_kept.end(), 0));
}

void checkOptions(const formats::PackOptions& options) {
  checkBits(options.position_bits, 8, "/position_bits");
  checkBits(options.normal_bits, 6, "/normal_bits");
}

std::map<std::string, double> precisionErrors(const formats::Pack& pack, const TensorFile& transfer) {
  const auto error = [&](const EncodedTable& table, const char* tensor) {
    return relativeError(table, transfer.tensors.at(tensor).as<float>());
  };
  const auto* sh = pack.transfer.as<formats::ShTransfer>();
  if (sh == nullptr || !sh->glossy) return {};
  const formats::Operator& stored = pack.sh().glossy->transfer;
  if (const auto* matrices = std::get_if<formats::MatrixOperator>(&stored))
    return {{"matrices", error(matrices->matrices, "matrix")}};
  if (const auto* visibility = std::get_if<formats::VisibilityOperator>(&stored))
    return {{"visibility", error(visibility->visibility, "visibility")}};
  const auto& clustered = std::get<formats::ClusteredOperator>(stored);
  return {{"weights", error(clustered.weights, "weights")}, {"basis", error(clustered.basis, "basis")}};
}

}  // namespace bakelight::packing
