#include "tools/pack/packing.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "formats/error.h"
#include "formats/materials.h"
#include "formats/mesh_ply.h"
#include "tools/pack/tensor_source.h"
#include "tools/pack/transfer_reader.h"

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

void setBaseColor(formats::Pack& pack, const formats::Float3& color) {
  for (formats::Appearance& appearance : pack.appearances) appearance.base_color = color;
}

// The albedo that interreflection was baked with, one for all or one a vertex; else the mesh's colours, else
// what the pack has already.
void takeAlbedo(const TensorSource& source, formats::Pack& pack) {
  auto mesh_colors = std::exchange(pack.mesh.colors, {});  // a pack has them outside of its mesh
  if (!source.has("albedo")) {
    if (mesh_colors.empty()) return;
    setBaseColor(pack, {1, 1, 1});
    pack.colors = std::move(mesh_colors);
    return;
  }
  const Tensor& tensor = source.tensor("albedo", 2);
  const std::uint64_t rows = tensor.shape[0], vertices = pack.mesh.vertexCount();
  if ((rows != 1 && rows != vertices) || tensor.shape[1] != 3) {
    throw source.error("tensor albedo", "its shape is " + shapeText(tensor.shape),
                       "1 × 3 or " + std::to_string(vertices) + " × 3, red, green and blue");
  }
  const auto values = tensor.as<float>();
  if (rows == 1) {
    setBaseColor(pack, {values[0], values[1], values[2]});
    return;
  }
  setBaseColor(pack, {1, 1, 1});
  pack.colors.resize(vertices);
  std::memcpy(pack.colors.data(), values.data(), values.size_bytes());
}

formats::BrdfTable brdfTable(const TensorFile& tensors, const std::string& file, int row_order) {
  const TensorSource source(tensors, file, "make it with the brdf tool of this version");
  source.requireText("basis", "real_sh_cartesian");
  source.requireText("frame", "local");
  source.requireText("cosine", "inside");
  formats::BrdfTable table;
  table.order = source.order("order");
  if (table.order < row_order) {
    throw source.error("metadata order", "it has fewer bands than the transferred radiance",
                       std::to_string(row_order) + " or more");
  }
  const std::uint64_t angles = source.tensor("brdf", 3).shape[0];
  const auto values =
      source.tensor("brdf", {angles, 3, squared(table.order)}, "angles × red, green, blue × order²")
          .as<float>();
  table.angles = static_cast<int>(angles);
  table.values.assign(values.begin(), values.end());
  return table;
}

void checkCombination(const std::string& lobe, bool is_glossy, bool has_brdf, const SourceNames& files) {
  const std::vector<std::string>& known = lobeNames();
  if (std::find(known.begin(), known.end(), lobe) == known.end())
    throw badInput({"", "", "/lobe"}, "there is no lobe '" + lobe + "'", "none, phong, ggx or table");
  const bool has_lobe = lobe != "none";
  if (has_lobe && !is_glossy) {
    throw badInput({files.transfer, "", "/lobe"}, "a lobe needs matrices, but this transfer is diffuse",
                   "none with diffuse transfer",
                   "bake with the transfer tool's technique glossy, or set lobe to none");
  }
  if (!has_lobe && is_glossy) {
    throw badInput({files.transfer, "", "/lobe"},
                   "this transfer is glossy, but without a lobe its matrices would never be used",
                   "phong, ggx or table", "set lobe, or bake with the transfer tool's technique diffuse");
  }
  if (lobe == formats::BrdfTable::kKind && !has_brdf) {
    throw badInput({"", "", "/brdf"}, "lobe table needs a projected BRDF", "a file of the brdf tool",
                   "give it as input brdf");
  }
  if (lobe != formats::BrdfTable::kKind && has_brdf) {
    throw badInput({files.brdf, "", "/brdf"}, "a BRDF table is of no use to lobe " + lobe, "lobe table",
                   "set lobe to table, or leave out the input brdf");
  }
}

formats::PackPart reflectionOf(const PackingOptions& options, const formats::ShTransfer& transfer,
                               const TensorFile* brdf, const std::string& brdf_file) {
  if (options.lobe == formats::PhongLobe::kKind)
    return formats::PhongLobe{static_cast<float>(options.exponent), options.specular_color};
  if (options.lobe == formats::GgxLobe::kKind)
    return formats::GgxLobe{static_cast<float>(options.roughness), options.specular_color};
  if (options.lobe == formats::BrdfTable::kKind)
    return brdfTable(*brdf, brdf_file, transfer.glossy->output_order);
  return formats::LambertReflection();
}

// One for each material that a triangle has; one without a name for a mesh that tells none apart.
std::vector<formats::Appearance> appearancesOf(formats::TriangleMesh& mesh) {
  std::vector<formats::Appearance> appearances;
  const std::vector<std::size_t> triangles = formats::trianglesOfMaterials(mesh);
  std::vector<std::uint32_t> index_of(triangles.size());
  for (std::size_t m = 0; m < triangles.size(); ++m) {
    if (triangles[m] == 0) continue;
    index_of[m] = static_cast<std::uint32_t>(appearances.size());
    appearances.push_back({.material = mesh.material_names[m]});
  }
  if (appearances.empty()) appearances.emplace_back();
  if (appearances.size() == 1) {
    mesh.triangle_materials.clear();
    mesh.material_names.clear();
    return appearances;
  }
  for (std::uint32_t& material : mesh.triangle_materials) material = index_of[material];
  mesh.material_names.clear();
  for (const formats::Appearance& appearance : appearances)
    mesh.material_names.push_back(appearance.material);
  return appearances;
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

const std::vector<std::string>& lobeNames() {
  static const std::vector<std::string> names = {"none", formats::PhongLobe::kKind, formats::GgxLobe::kKind,
                                                 formats::BrdfTable::kKind};
  return names;
}

formats::Pack assemblePack(formats::TriangleMesh mesh, const TensorFile& transfer, const TensorFile* brdf,
                           const PackingOptions& options, const SourceNames& files) {
  const TensorSource source(transfer, files.transfer,
                            "bake it again, for this mesh and by the transfer tool of this version");
  formats::ShTransfer read = readTransfer(source, mesh.vertexCount(), options.precision);
  requireSameMesh(source, mesh, files.mesh);
  checkCombination(options.lobe, read.glossy.has_value(), brdf != nullptr, files);
  const formats::PackPart reflection = reflectionOf(options, read, brdf, files.brdf);
  std::vector<formats::Appearance> appearances = appearancesOf(mesh);
  for (formats::Appearance& appearance : appearances) appearance.reflection = reflection;
  formats::Pack pack{options.name, std::move(mesh), {}, std::move(read), std::move(appearances)};
  setBaseColor(pack, options.albedo);
  takeAlbedo(source, pack);
  return pack;
}

void orderByMaterial(formats::Pack& pack) {
  if (pack.appearances.size() == 1) return;
  formats::TriangleMesh& mesh = pack.mesh;
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> source, materials;
  std::vector<formats::Triangle> triangles;
  for (std::uint32_t material = 0; material < pack.appearances.size(); ++material) {
    std::vector<std::uint8_t> is_used(mesh.vertexCount(), 0);
    for (std::size_t t = 0; t < mesh.triangleCount(); ++t)
      if (mesh.triangle_materials[t] == material)
        for (const std::uint32_t v : mesh.triangles[t]) is_used[v] = 1;
    std::vector<std::uint32_t> target(mesh.vertexCount(), kNone);
    for (std::uint32_t v = 0; v < is_used.size(); ++v) {
      if (is_used[v] == 0) continue;
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
}

void checkOptions(const formats::PackOptions& options) {
  checkBits(options.position_bits, 8, "/position_bits");
  checkBits(options.normal_bits, 6, "/normal_bits");
}

std::map<std::string, double> precisionErrors(const formats::Pack& pack, const TensorFile& transfer) {
  const auto error = [&](const EncodedTable& table, const char* tensor) {
    return relativeError(table, transfer.tensors.at(tensor).as<float>());
  };
  if (!pack.sh().glossy) return {};
  const formats::Operator& stored = pack.sh().glossy->transfer;
  if (const auto* matrices = std::get_if<formats::MatrixOperator>(&stored))
    return {{"matrices", error(matrices->matrices, "matrix")}};
  if (const auto* visibility = std::get_if<formats::VisibilityOperator>(&stored))
    return {{"visibility", error(visibility->visibility, "visibility")}};
  const auto& clustered = std::get<formats::ClusteredOperator>(stored);
  return {{"weights", error(clustered.weights, "weights")}, {"basis", error(clustered.basis, "basis")}};
}

}  // namespace bakelight::packing
