#include "tools/pack/packing.h"

#include <cmath>
#include <cstring>
#include <utility>

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

// The albedo that interreflection was baked with, one for all or one a vertex; else the mesh's colours, else
// what the pack has already.
void takeAlbedo(const TensorSource& source, formats::Pack& pack) {
  auto mesh_colors = std::exchange(pack.mesh.colors, {});  // a pack has them outside of its mesh
  if (!source.has("albedo")) {
    if (mesh_colors.empty()) return;
    pack.base_color = {1, 1, 1};
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
    pack.base_color = {values[0], values[1], values[2]};
    return;
  }
  pack.base_color = {1, 1, 1};
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

LobeModel lobeNamed(const std::string& name) {
  for (const auto model : {LobeModel::kNone, LobeModel::kPhong, LobeModel::kGgx, LobeModel::kTable}) {
    if (name == nameOf(model)) return model;
  }
  throw badInput({"", "", "/lobe"}, "there is no lobe '" + name + "'", "none, phong, ggx or table");
}

void checkCombination(LobeModel lobe, MatrixStorage storage, bool has_brdf, const SourceNames& files) {
  if (lobe != LobeModel::kNone && storage == MatrixStorage::kNone) {
    throw badInput({files.transfer, "", "/lobe"}, "a lobe needs matrices, but this transfer is diffuse",
                   "none with diffuse transfer",
                   "bake with the transfer tool's technique glossy, or set lobe to none");
  }
  if (lobe == LobeModel::kNone && storage != MatrixStorage::kNone) {
    throw badInput({files.transfer, "", "/lobe"},
                   "this transfer is glossy, but without a lobe its matrices would never be used",
                   "phong, ggx or table", "set lobe, or bake with the transfer tool's technique diffuse");
  }
  if (lobe == LobeModel::kTable && !has_brdf) {
    throw badInput({"", "", "/brdf"}, "lobe table needs a projected BRDF", "a file of the brdf tool",
                   "give it as input brdf");
  }
  if (lobe != LobeModel::kTable && has_brdf) {
    throw badInput({files.brdf, "", "/brdf"},
                   std::string("a BRDF table is of no use to lobe ") + nameOf(lobe), "lobe table",
                   "set lobe to table, or leave out the input brdf");
  }
}

formats::GlossyMaterial materialOf(LobeModel lobe, int row_order, const PackingOptions& options,
                                   const TensorFile* brdf, const std::string& brdf_file) {
  formats::GlossyMaterial material;
  material.model = lobe;
  if (lobe == LobeModel::kNone) return material;
  if (lobe == LobeModel::kTable) {
    material.table = brdfTable(*brdf, brdf_file, row_order);
    return material;
  }
  material.specular_color = options.specular_color;
  if (lobe == LobeModel::kPhong) material.exponent = static_cast<float>(options.exponent);
  if (lobe == LobeModel::kGgx) material.roughness = static_cast<float>(options.roughness);
  return material;
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
  static const std::vector<std::string> names = {nameOf(LobeModel::kNone), nameOf(LobeModel::kPhong),
                                                 nameOf(LobeModel::kGgx), nameOf(LobeModel::kTable)};
  return names;
}

formats::Pack assemblePack(formats::TriangleMesh mesh, const TensorFile& transfer, const TensorFile* brdf,
                           const PackingOptions& options, const SourceNames& files) {
  const TensorSource source(transfer, files.transfer,
                            "bake it again, for this mesh and by the transfer tool of this version");
  formats::Pack pack{options.name, std::move(mesh), options.albedo, {}, {}};
  pack.transfer = readTransfer(source, pack.mesh.vertexCount(), options.precision);
  requireSameMesh(source, pack.mesh, files.mesh);
  takeAlbedo(source, pack);
  const LobeModel lobe = lobeNamed(options.lobe);
  checkCombination(lobe, pack.transfer.storage, brdf != nullptr, files);
  pack.transfer.material = materialOf(lobe, pack.transfer.row_order, options, brdf, files.brdf);
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
