#include "tools/pack/transfer_reader.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>

#include "formats/sum_grammar_file.h"

namespace bakelight::packing {
namespace {

using formats::ElementType;
using formats::EncodedTable;
using formats::Precision;
using formats::Tensor;

class TransferReader {
 public:
  TransferReader(const TensorSource& source, std::uint64_t vertices, Precision precision)
      : source_(source), vertices_(vertices), precision_(precision) {}

  formats::ShTransfer read() {
    const std::string& technique = source_.text("technique");
    if (technique != "diffuse" && technique != "glossy") {
      throw source_.error("metadata technique", "it is '" + technique + "'", "'diffuse' or 'glossy'");
    }
    source_.requireText("basis", "real_sh_cartesian");
    source_.requireText("albedo", "outside");
    source_.requireText("inverse_pi", "inside");
    result_.order = source_.order("order");
    result_.transport = transportOf(source_.text("transport"));
    readDiffuse();
    if (source_.has("near_transfer")) readNearField();
    if (technique == "glossy") readGlossy();
    return std::move(result_);
  }

 private:
  std::uint64_t channels() const { return static_cast<std::uint64_t>(result_.channels); }
  std::uint64_t matrixValues() const {
    return channels() * squared(result_.glossy->output_order) * squared(result_.order);
  }

  formats::Transport transportOf(const std::string& name) const {
    if (const formats::Transport* known = formats::valueFor(formats::kTransports, name)) return *known;
    throw source_.error("metadata transport", "it is '" + name + "'",
                        "'unshadowed', 'shadowed' or 'interreflected'");
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
    const auto sphere = source_.tensor("sphere", {4}, "centre and radius").as<float>();
    result_.near_field = {{sphere[0], sphere[1], sphere[2]}, sphere[3], vectors("near_transfer")};
  }

  void readGlossy() {
    formats::GlossyTransfer& glossy = result_.glossy.emplace();
    glossy.output_order = source_.order("row_order");
    readTangents();
    const std::string& storage = source_.text("storage");
    if (storage == "matrix") {
      glossy.transfer = readMatrices();
    } else if (storage == "visibility") {
      glossy.transfer = readVisibility();
    } else if (storage == "cpca") {
      glossy.transfer = readClusters();
    } else {
      throw source_.error("metadata storage", "it is '" + storage + "'", "'matrix', 'visibility' or 'cpca'");
    }
  }

  void readTangents() {
    const auto values = source_.tensor("tangent", {vertices_, 4}, "vertices × (x, y, z, sign)").as<float>();
    std::vector<formats::Float4>& tangents = result_.glossy->tangents;
    tangents.resize(vertices_);
    if (!values.empty()) std::memcpy(tangents.data(), values.data(), values.size_bytes());
  }

  formats::MatrixOperator readMatrices() const {
    const Tensor& tensor = source_.tensor(
        "matrix", {vertices_, channels(), squared(result_.glossy->output_order), squared(result_.order)},
        "vertices × channels × row_order² × order²");
    return {source_.table("matrix", tensor, matrixValues(), precision_)};
  }

  formats::VisibilityOperator readVisibility() const {
    if (result_.channels != 1) {
      throw source_.error("metadata storage", "visibility has no colour, but the transfer has 3 channels",
                          "1 channel; or storage matrix or cpca, which hold coloured interreflection");
    }
    const std::uint64_t values = squared(result_.glossy->output_order + result_.order - 1);
    const Tensor& tensor =
        source_.tensor("visibility", {vertices_, values}, "vertices × (row_order + order − 1)²");
    return {source_.table("visibility", tensor, values, precision_)};
  }

  formats::ClusteredOperator readClusters() const {
    const Tensor& weights = source_.tensor("weights", 2);
    const std::uint64_t components = weights.shape[1];
    if (weights.shape[0] != vertices_ || components == 0) {
      throw source_.error("tensor weights", "its shape is " + shapeText(weights.shape),
                          std::to_string(vertices_) + " × 1 or more, vertices × weights");
    }
    formats::ClusteredOperator result;
    result.weights = source_.table("weights", weights, components, precision_);
    const Tensor& basis = source_.tensor("basis", 5);
    source_.tensor("basis",
                   {basis.shape[0], 1 + components, channels(), squared(result_.glossy->output_order),
                    squared(result_.order)},
                   "clusters × (1 + weights) × channels × row_order² × order²");
    result.basis = source_.table("basis", basis, matrixValues(),
                                 precision_ == Precision::kUint8 ? Precision::kFloat16 : precision_);
    const auto clusters =
        source_.tensor("cluster", {vertices_}, "one a vertex", ElementType::kUint32).as<std::uint32_t>();
    result.clusters.assign(clusters.begin(), clusters.end());
    return result;
  }

  const TensorSource& source_;
  std::uint64_t vertices_;
  Precision precision_;
  formats::ShTransfer result_;
};

}  // namespace

formats::ShTransfer readTransfer(const TensorSource& source, std::uint64_t vertices, Precision precision) {
  return TransferReader(source, vertices, precision).read();
}

bool isPixelTechnique(const std::string& technique) {
  return technique == "pixel" || technique == "sum_grammar";
}

namespace {

std::vector<formats::Float4> tangentsOf(const TensorSource& source, std::uint64_t vertices) {
  const auto values = source.tensor("tangents", {vertices, 4}, "vertices × (x, y, z, sign)").as<float>();
  std::vector<formats::Float4> tangents(vertices);
  if (!values.empty()) std::memcpy(tangents.data(), values.data(), values.size_bytes());
  return tangents;
}

formats::PixelTransfer readSums(const TensorSource& source, std::uint64_t vertices) {
  const formats::CodedSums coded = formats::codedSumsOf(source.tensors(), source.file());
  const std::uint64_t rows = vertices * squared(coded.local_side);
  if (coded.row_count != rows)
    throw source.error("metadata rows", "it is " + std::to_string(coded.row_count),
                       std::to_string(rows) + ", local_side² for each vertex of the mesh");
  auto grammar = std::make_shared<const formats::SumGrammar>(formats::decodeSums(coded, source.file()));
  return formats::pixelTransferOf(coded, std::move(grammar), tangentsOf(source, vertices));
}

formats::PixelTransfer readRows(const TensorSource& source, std::uint64_t vertices) {
  formats::PixelCodes codes;
  codes.cube_side = source.integer("cube_side", formats::kMostCubeSide);
  codes.local_side = source.integer("local_side", formats::kMostLocalSide);
  codes.subsamples = source.integer("subsamples", formats::kMostSubsamples);
  const std::uint64_t rows = vertices * squared(codes.local_side);
  codes.row_offsets =
      source.tensor("row_offsets", {rows + 1}, "vertices × local_side² + 1", ElementType::kInt64)
          .as<std::uint64_t>();
  const std::uint64_t entries = codes.row_offsets.back();
  codes.columns =
      source.tensor("columns", {entries}, "as many as row_offsets ends with", ElementType::kUint16)
          .as<std::uint16_t>();
  codes.codes = source.tensor("codes", {entries}, "as many as row_offsets ends with", ElementType::kUint8)
                    .as<std::uint8_t>();
  const std::uint64_t most = codes.columnCount();
  for (std::uint64_t row = 0; row < rows; ++row)
    if (codes.row_offsets[row] > codes.row_offsets[row + 1] ||
        codes.row_offsets[row + 1] - codes.row_offsets[row] > most || (row == 0 && codes.row_offsets[0] != 0))
      throw source.error("tensor row_offsets, row " + std::to_string(row),
                         "it ends at " + std::to_string(codes.row_offsets[row + 1]) + " and begins at " +
                             std::to_string(codes.row_offsets[row]),
                         "from 0 on, no row longer than " + std::to_string(most) + " texels");
  return formats::pixelTransferOf(codes, tangentsOf(source, vertices));
}

}  // namespace

formats::PixelTransfer readPixelTransfer(const TensorSource& source, std::uint64_t vertices) {
  const bool has_sums = source.text("technique") == "sum_grammar";
  formats::PixelTransfer transfer = has_sums ? readSums(source, vertices) : readRows(source, vertices);
  constexpr float kMostError = std::numeric_limits<float>::max();
  if (source.tensors().metadata.contains("tolerance"))
    transfer.changes = {source.number("tolerance", 1), source.number("largest_error", kMostError),
                        source.number("rms_error", kMostError)};
  return transfer;
}

}  // namespace bakelight::packing
