#include "tools/pack/packing.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <utility>

#include "formats/error.h"
#include "formats/mesh_ply.h"

namespace bakelight::packing {
namespace {

using formats::ElementType;
using formats::EncodedTable;
using formats::Float3;
using formats::LobeModel;
using formats::MatrixStorage;
using formats::Precision;
using formats::Tensor;
using formats::TensorFile;

std::uint64_t squared(int order) {
  return static_cast<std::uint64_t>(order) * static_cast<std::uint64_t>(order);
}

std::string shapeText(const std::vector<std::uint64_t>& shape) {
  std::string text;
  for (const std::uint64_t extent : shape) text += (text.empty() ? "" : " × ") + std::to_string(extent);
  return text;
}

// A tensor file whose statements are checked as they are read.
class Source {
 public:
  Source(const TensorFile& tensors, const std::string& file, std::string remedy)
      : tensors_(tensors), file_(file), remedy_(std::move(remedy)) {}

  Error error(const std::string& element, const std::string& what, const std::string& expected) const {
    return badInput({file_, element, ""}, what, expected, remedy_);
  }

  const std::string& text(const char* key) const { return tensors_.requireMetadata(key, file_); }

  void requireText(const char* key, const std::string& expected) const {
    if (text(key) == expected) return;
    throw error(std::string("metadata ") + key, "it is '" + text(key) + "'", "'" + expected + "'");
  }

  int order(const char* key) const {
    const std::string& digits = text(key);
    int order = 0;
    const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), order);
    if (status == std::errc() && end == digits.data() + digits.size() && order >= 1 && order <= 10)
      return order;
    throw error(std::string("metadata ") + key, "it is '" + digits + "'", "1 to 10");
  }

  bool has(const char* name) const { return tensors_.tensors.contains(name); }

  const Tensor& tensor(const char* name, std::size_t rank, ElementType type = ElementType::kFloat32) const {
    return tensors_.require(name, type, rank, file_);
  }

  // `expected` says in words what the extents are.
  const Tensor& tensor(const char* name, const std::vector<std::uint64_t>& shape, const std::string& expected,
                       ElementType type = ElementType::kFloat32) const {
    const Tensor& found = tensor(name, shape.size(), type);
    if (found.shape == shape) return found;
    throw error(std::string("tensor ") + name, "its shape is " + shapeText(found.shape),
                shapeText(shape) + ", " + expected);
  }

  EncodedTable table(const char* name, const Tensor& tensor, std::uint64_t columns,
                     Precision precision) const {
    return encodeTable(tensor.as<float>(), columns, precision, file_, std::string("tensor ") + name);
  }

 private:
  const TensorFile& tensors_;
  const std::string& file_;
  std::string remedy_;
};

// ---- the transfer file

class TransferReader {
 public:
  TransferReader(const Source& source, std::uint64_t vertices, Precision precision)
      : source_(source), vertices_(vertices), precision_(precision) {}

  formats::RadianceTransfer read() {
    source_.requireText("basis", "real_sh_cartesian");
    source_.requireText("albedo", "outside");
    source_.requireText("inverse_pi", "inside");
    result_.order = source_.order("order");
    result_.transport = source_.text("transport");
    readDiffuse();
    if (source_.has("near_transfer")) readNearField();
    const std::string& technique = source_.text("technique");
    if (technique == "glossy") {
      readGlossy();
    } else if (technique != "diffuse") {
      throw source_.error("metadata technique", "it is '" + technique + "'", "'diffuse' or 'glossy'");
    }
    return std::move(result_);
  }

 private:
  std::uint64_t channels() const { return static_cast<std::uint64_t>(result_.channels); }
  std::uint64_t matrixValues() const {
    return channels() * squared(result_.row_order) * squared(result_.order);
  }

  EncodedTable vectors(const char* name) const {
    const Tensor& tensor =
        source_.tensor(name, {vertices_, channels(), squared(result_.order)}, "vertices × channels × order²");
    return source_.table(name, tensor, channels() * squared(result_.order), Precision::kFloat32);
  }

  void readDiffuse() {
    const std::uint64_t channel_count = source_.tensor("transfer", 3).shape[1];
    if (channel_count != 1 && channel_count != 3) {
      throw source_.error("tensor transfer", "it has " + std::to_string(channel_count) + " channels",
                          "1 or 3");
    }
    result_.channels = static_cast<int>(channel_count);
    result_.vectors = vectors("transfer");
  }

  void readNearField() {
    result_.near_vectors = vectors("near_transfer");
    const auto sphere = source_.tensor("sphere", {4}, "centre and radius").as<float>();
    result_.sphere_center = {sphere[0], sphere[1], sphere[2]};
    result_.sphere_radius = sphere[3];
  }

  void readGlossy() {
    result_.row_order = source_.order("row_order");
    readTangents();
    const std::string& storage = source_.text("storage");
    if (storage == "matrix") {
      readMatrices();
    } else if (storage == "visibility") {
      readVisibility();
    } else if (storage == "cpca") {
      readClusters();
    } else {
      throw source_.error("metadata storage", "it is '" + storage + "'", "'matrix', 'visibility' or 'cpca'");
    }
  }

  void readTangents() {
    const auto values = source_.tensor("tangent", {vertices_, 4}, "vertices × (x, y, z, sign)").as<float>();
    result_.tangents.resize(vertices_);
    if (!values.empty()) std::memcpy(result_.tangents.data(), values.data(), values.size_bytes());
  }

  void readMatrices() {
    result_.storage = MatrixStorage::kMatrix;
    const Tensor& tensor =
        source_.tensor("matrix", {vertices_, channels(), squared(result_.row_order), squared(result_.order)},
                       "vertices × channels × row_order² × order²");
    result_.matrices = source_.table("matrix", tensor, matrixValues(), precision_);
  }

  void readVisibility() {
    result_.storage = MatrixStorage::kVisibility;
    if (result_.channels != 1) {
      throw source_.error("metadata storage", "visibility has no colour, but the transfer has 3 channels",
                          "1 channel; or storage matrix or cpca, which hold coloured interreflection");
    }
    const std::uint64_t values = squared(result_.row_order + result_.order - 1);
    const Tensor& tensor =
        source_.tensor("visibility", {vertices_, values}, "vertices × (row_order + order − 1)²");
    result_.matrices = source_.table("visibility", tensor, values, precision_);
  }

  void readClusters() {
    result_.storage = MatrixStorage::kCpca;
    const Tensor& weights = source_.tensor("weights", 2);
    const std::uint64_t components = weights.shape[1];
    if (weights.shape[0] != vertices_ || components == 0) {
      throw source_.error("tensor weights", "its shape is " + shapeText(weights.shape),
                          std::to_string(vertices_) + " × 1 or more, vertices × weights");
    }
    result_.matrices = source_.table("weights", weights, components, precision_);
    const Tensor& basis = source_.tensor("basis", 5);
    source_.tensor(
        "basis",
        {basis.shape[0], 1 + components, channels(), squared(result_.row_order), squared(result_.order)},
        "clusters × (1 + weights) × channels × row_order² × order²");
    result_.basis = source_.table("basis", basis, matrixValues(),
                                  precision_ == Precision::kUint8 ? Precision::kFloat16 : precision_);
    const auto clusters =
        source_.tensor("cluster", {vertices_}, "one a vertex", ElementType::kUint32).as<std::uint32_t>();
    result_.clusters.assign(clusters.begin(), clusters.end());
  }

  const Source& source_;
  std::uint64_t vertices_;
  Precision precision_;
  formats::RadianceTransfer result_;
};

// ---- what the transfer meets: mesh, albedo, lobe

void requireSameMesh(const Source& source, const formats::TriangleMesh& mesh, const std::string& mesh_file) {
  const auto& shape = source.tensor("transfer", 3).shape;
  if (shape[0] != mesh.vertexCount()) {
    throw source.error("tensor transfer", "it is for " + std::to_string(shape[0]) + " vertices",
                       std::to_string(mesh.vertexCount()) + ", the vertices of " + mesh_file);
  }
  const std::string hash = formats::geometryHash(mesh);
  if (source.text("mesh_hash") == hash) return;
  throw source.error("metadata mesh_hash", "the transfer was baked for another mesh than " + mesh_file, hash);
}

// The albedo that interreflection was baked with, one for all or one a vertex.
void takeAlbedo(const Source& source, formats::Pack& pack) {
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

formats::BrdfTable brdfTable(const TensorFile& tensors, const std::string& file) {
  const Source source(tensors, file, "make it with the brdf tool of this version");
  source.requireText("basis", "real_sh_cartesian");
  source.requireText("frame", "local");
  source.requireText("cosine", "inside");
  formats::BrdfTable table;
  table.order = source.order("order");
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

formats::GlossyMaterial materialOf(LobeModel lobe, const PackingOptions& options, const TensorFile* brdf,
                                   const std::string& brdf_file) {
  formats::GlossyMaterial material;
  material.model = lobe;
  if (lobe == LobeModel::kNone) return material;
  if (lobe == LobeModel::kTable) {
    material.table = brdfTable(*brdf, brdf_file);
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
  const Source source(transfer, files.transfer,
                      "bake it again, for this mesh and by the transfer tool of this version");
  requireSameMesh(source, mesh, files.mesh);
  formats::Pack pack{options.name, std::move(mesh), options.albedo, {}, {}};
  if (source.has("albedo")) takeAlbedo(source, pack);
  pack.transfer = TransferReader(source, pack.mesh.vertexCount(), options.precision).read();
  const LobeModel lobe = lobeNamed(options.lobe);
  checkCombination(lobe, pack.transfer.storage, brdf != nullptr, files);
  pack.transfer.material = materialOf(lobe, options, brdf, files.brdf);
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
