#include "tools/pack/transfer_reader.h"

#include <cstring>
#include <utility>

namespace bakelight::packing {
namespace {

using formats::ElementType;
using formats::EncodedTable;
using formats::MatrixStorage;
using formats::Precision;
using formats::Tensor;

class TransferReader {
 public:
  TransferReader(const TensorSource& source, std::uint64_t vertices, Precision precision)
      : source_(source), vertices_(vertices), precision_(precision) {}

  formats::RadianceTransfer read() {
    const std::string& technique = source_.text("technique");
    if (technique != "diffuse" && technique != "glossy") {
      throw source_.error("metadata technique", "it is '" + technique + "'", "'diffuse' or 'glossy'");
    }
    source_.requireText("basis", "real_sh_cartesian");
    source_.requireText("albedo", "outside");
    source_.requireText("inverse_pi", "inside");
    result_.order = source_.order("order");
    result_.transport = source_.text("transport");
    readDiffuse();
    if (source_.has("near_transfer")) readNearField();
    if (technique == "glossy") readGlossy();
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

  const TensorSource& source_;
  std::uint64_t vertices_;
  Precision precision_;
  formats::RadianceTransfer result_;
};

}  // namespace

formats::RadianceTransfer readTransfer(const TensorSource& source, std::uint64_t vertices,
                                       Precision precision) {
  return TransferReader(source, vertices, precision).read();
}

}  // namespace bakelight::packing
