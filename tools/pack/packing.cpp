#include "tools/pack/packing.h"

#include <cmath>
#include <utility>
#include <variant>

#include "formats/error.h"
#include "formats/mesh_ply.h"
#include "tools/pack/tensor_source.h"
#include "tools/pack/transfer_reader.h"

namespace bakelight::packing {
namespace {

using formats::EncodedTable;
using formats::LobeModel;
using formats::MatrixStorage;
using formats::Tensor;
using formats::TensorFile;

void requireSameMesh(const TensorSource& source, const formats::TriangleMesh& mesh,
                     const std::string& mesh_file) {
  const std::string hash = formats::geometryHash(mesh);
  if (source.text("mesh_hash") == hash) return;
  throw source.error("metadata mesh_hash", "the transfer was baked for another mesh than " + mesh_file, hash);
}

// That light was baked to bounce off the albedo that is shown, one for all or one a vertex.
void requireSameAlbedo(const TensorSource& source, const formats::Pack& pack,
                       const formats::SurfaceMaterials& material) {
  if (!source.has("albedo")) return;
  const Tensor& tensor = source.tensor("albedo", 2);
  const std::uint64_t rows = tensor.shape[0], vertices = pack.mesh.vertexCount();
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
  pack.base_color = material.vertex_albedo.empty() ? material.albedo : formats::Float3{1, 1, 1};
  pack.colors = material.vertex_albedo;
}

constexpr const char* kTable = "table";
constexpr const char* kNone = "none";

formats::BrdfTable tableFor(const formats::Reflection& reflection, int row_order, const TensorFile* brdf,
                            const SourceNames& files) {
  const auto* own = std::get_if<formats::TableReflection>(&reflection);
  if (brdf == nullptr && own == nullptr)
    throw badInput({"", "", "/brdf"}, "a table needs a projected BRDF", "a file of the brdf tool",
                   "give it as input brdf");
  const std::string file = brdf != nullptr ? files.brdf : own->file.string();
  formats::BrdfTable table = brdf != nullptr ? formats::brdfTableFrom(*brdf, file) : own->table;
  if (table.order < row_order)
    throw badInput({file, "metadata order", ""}, "it has fewer bands than the transferred radiance",
                   std::to_string(row_order) + " or more", "make it with the brdf tool of this version");
  return table;
}

formats::GlossyMaterial reflectionFor(int row_order, const PackingOptions& options, const TensorFile* brdf,
                                      const SourceNames& files) {
  if (options.reflection == kNone) return {};
  const formats::Reflection* const reflection = options.material.only();
  if (reflection == nullptr)
    throw badInput({files.material, "", "/materials"},
                   "its materials reflect differently, and a pack holds one reflection",
                   "the same reflection for all; albedos may differ");
  if (options.reflection != kTable && !std::holds_alternative<formats::TableReflection>(*reflection))
    return runtimeLobe(*reflection);
  formats::GlossyMaterial material;
  material.model = LobeModel::kTable;
  material.table = tableFor(*reflection, row_order, brdf, files);
  return material;
}

void checkCombination(LobeModel lobe, MatrixStorage storage, const SourceNames& files) {
  if (lobe != LobeModel::kNone && storage == MatrixStorage::kNone) {
    throw badInput({files.transfer, "", "/reflection"},
                   "a glossy reflection needs matrices, but this transfer is diffuse",
                   "a material without one, or reflection none",
                   "bake with the transfer tool's technique glossy, as the recipe glossy does");
  }
  if (lobe == LobeModel::kNone && storage != MatrixStorage::kNone) {
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

const std::vector<std::string>& reflectionNames() {
  static const std::vector<std::string> names = {"lobe", kTable, kNone};
  return names;
}

formats::Pack assemblePack(formats::TriangleMesh mesh, const TensorFile& transfer, const TensorFile* brdf,
                           const PackingOptions& options, const SourceNames& files) {
  const TensorSource source(transfer, files.transfer,
                            "bake it again, for this mesh and by the transfer tool of this version");
  formats::Pack pack{options.name, std::move(mesh), {}, {}, {}};
  pack.transfer = readTransfer(source, pack.mesh.vertexCount(), options.precision);
  requireSameMesh(source, pack.mesh, files.mesh);
  requireSameAlbedo(source, pack, options.material);
  takeAlbedo(options.material, pack);
  pack.transfer.material = reflectionFor(pack.transfer.row_order, options, brdf, files);
  checkCombination(pack.transfer.material.model, pack.transfer.storage, files);
  return pack;
}

void checkOptions(const formats::PackOptions& options) {
  checkBits(options.position_bits, 8, "/position_bits");
  checkBits(options.normal_bits, 6, "/normal_bits");
}

std::map<std::string, double> precisionErrors(const formats::Pack& pack, const TensorFile& transfer) {
  const auto error = [&](const EncodedTable& table, const char* tensor) {
    return relativeError(table, transfer.tensors.at(tensor).as<float>());
  };
  const EncodedTable& matrices = pack.transfer.matrices;
  switch (pack.transfer.storage) {
    case MatrixStorage::kNone:
      break;
    case MatrixStorage::kMatrix:
      return {{"matrices", error(matrices, "matrix")}};
    case MatrixStorage::kVisibility:
      return {{"visibility", error(matrices, "visibility")}};
    case MatrixStorage::kCpca:
      return {{"weights", error(matrices, "weights")}, {"basis", error(pack.transfer.basis, "basis")}};
  }
  return {};
}

}  // namespace bakelight::packing
