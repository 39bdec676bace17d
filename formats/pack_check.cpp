#include "formats/pack_check.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "formats/error.h"

namespace bakelight::formats {
namespace {

// Of a length that should be 1, and of a cosine that should be 0; the Khronos validator asks for 5e-3 or so.
constexpr float kUnitTolerance = 1e-3F;
constexpr std::uint16_t kHalfExponent = 0x7C00;

std::size_t squared(int order) {
  return static_cast<std::size_t>(order) * static_cast<std::size_t>(order);
}

template <std::size_t N>
bool isFinite(const std::array<float, N>& values) {
  return std::all_of(values.begin(), values.end(), [](float value) { return std::isfinite(value); });
}

float dot(const Float3& a, const Float3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// False for NaN, too.
bool isUnit(const Float3& v) {
  return std::abs(std::sqrt(dot(v, v)) - 1) <= kUnitTolerance;
}

bool isReflectance(const Float3& color) {
  return std::all_of(color.begin(), color.end(), [](float value) { return value >= 0 && value <= 1; });
}

class Checker {
 public:
  Checker(const Pack& pack, const std::string& file)
      : mesh_(pack.mesh), transfer_(pack.transfer), pack_(pack), file_(file) {}

  void check() const {
    checkMeshSizes();
    checkVertices();
    checkTriangles();
    checkColors();
    checkDiffuse();
    checkNearField();
    if (transfer_.storage == MatrixStorage::kNone) {
      checkNothingGlossy();
    } else {
      checkFrames();
      checkMatrices();
      checkMaterial();
    }
  }

 private:
  Error error(const std::string& element, const std::string& what, const std::string& expected,
              const std::string& remedy = "") const {
    return badInput({file_, element, ""}, what, expected, remedy);
  }

  void checkCount(const char* section, std::size_t count, const std::string& remedy = "") const {
    if (count == mesh_.vertexCount()) return;
    throw error(section, "it has " + std::to_string(count) + " entries",
                "one for each of the " + std::to_string(mesh_.vertexCount()) + " vertices", remedy);
  }

  void checkMeshSizes() const {
    const std::size_t count = mesh_.vertexCount();
    if (count == 0 || mesh_.triangles.empty()) {
      throw error("mesh", "it has no " + std::string(count == 0 ? "vertex" : "triangle"),
                  "at least one triangle");
    }
    if (count >= std::numeric_limits<std::uint32_t>::max()) {
      throw error("mesh", "it has " + std::to_string(count) + " vertices", "fewer than 4,294,967,295");
    }
    checkCount("normals", mesh_.normals.size(), "run the simplify tool on the mesh, which computes them");
    if (!mesh_.texcoords.empty()) checkCount("texcoords", mesh_.texcoords.size());
  }

  void checkVertices() const {
    for (std::size_t i = 0; i < mesh_.vertexCount(); ++i) {
      const bool texcoord_ok = mesh_.texcoords.empty() || isFinite(mesh_.texcoords[i]);
      if (!isFinite(mesh_.positions[i]) || !isFinite(mesh_.normals[i]) || !texcoord_ok) {
        throw error("vertex " + std::to_string(i), "it has values that are not finite", "numbers");
      }
      if (!isUnit(mesh_.normals[i])) {
        throw error(
            "vertex " + std::to_string(i),
            "its normal has length " + std::to_string(std::sqrt(dot(mesh_.normals[i], mesh_.normals[i]))),
            "1");
      }
    }
  }

  void checkTriangles() const {
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      for (const std::uint32_t index : mesh_.triangles[i]) {
        if (index < mesh_.vertexCount()) continue;
        throw error("triangle " + std::to_string(i), "vertex " + std::to_string(index) + " does not exist",
                    "less than " + std::to_string(mesh_.vertexCount()));
      }
    }
  }

  void checkColors() const {
    if (!isReflectance(pack_.base_color)) throw error("base colour", "it is out of range", "0 to 1");
    if (pack_.colors.empty()) return;
    checkCount("colors", pack_.colors.size());
    for (std::size_t i = 0; i < pack_.colors.size(); ++i) {
      if (isReflectance(pack_.colors[i])) continue;
      throw error("colors, vertex " + std::to_string(i), "it is out of range", "0 to 1");
    }
  }

  // `expected` says in words what rows × columns are.
  void checkTable(const EncodedTable& table, std::size_t rows, std::size_t columns,
                  const std::string& section, const std::string& expected) const {
    if (table.rows != rows || table.columns != columns) {
      throw error("section " + section,
                  "it has " + std::to_string(table.rows) + " rows of " + std::to_string(table.columns),
                  expected, "bake the transfer again, for this mesh");
    }
    const auto bytes = checkedProduct({rows, columns, bytesPerValue(table.precision)});
    const std::size_t ranges = table.precision == Precision::kUint8 ? columns : 0;
    if (!bytes || table.data.size() != *bytes || table.scale.size() != ranges ||
        table.offset.size() != ranges) {
      throw error("section " + section,
                  "its data do not have the size that rows, columns and precision ask for", expected);
    }
    checkFinite(table, section);
  }

  void checkFinite(const EncodedTable& table, const std::string& section) const {
    const auto notFinite = [&](std::size_t i) {
      return error("section " + section + ", row " + std::to_string(i / table.columns),
                   "value " + std::to_string(i % table.columns) + " is not finite", "a number");
    };
    for (std::size_t i = 0; i < table.scale.size(); ++i) {
      if (!std::isfinite(table.offset[i] + table.scale[i] * 255) || !std::isfinite(table.offset[i])) {
        throw error("section " + section + ", column " + std::to_string(i), "its range is not finite",
                    "numbers");
      }
    }
    const std::size_t count = table.rows * table.columns;
    for (std::size_t i = 0; i < count && table.precision == Precision::kFloat32; ++i) {
      float value;
      std::memcpy(&value, table.data.data() + i * sizeof value, sizeof value);
      if (!std::isfinite(value)) throw notFinite(i);
    }
    for (std::size_t i = 0; i < count && table.precision == Precision::kFloat16; ++i) {
      std::uint16_t bits;
      std::memcpy(&bits, table.data.data() + i * sizeof bits, sizeof bits);
      if ((bits & kHalfExponent) == kHalfExponent) throw notFinite(i);
    }
  }

  std::string perVertex(std::size_t values, const std::string& what) const {
    return std::to_string(mesh_.vertexCount()) + " vertices × " + std::to_string(values) + " " + what;
  }

  void checkOrder(int order, const char* element) const {
    if (order < 1 || order > kMaxOrder) throw error(element, "it is " + std::to_string(order), "1 to 10");
  }

  std::size_t channels() const { return static_cast<std::size_t>(transfer_.channels); }

  void checkDiffuse() const {
    checkOrder(transfer_.order, "order of the transfer");
    if (transfer_.transport != "unshadowed" && transfer_.transport != "shadowed" &&
        transfer_.transport != "interreflected") {
      throw error("transfer", "its transport is '" + transfer_.transport + "'",
                  "unshadowed, shadowed or interreflected");
    }
    if (transfer_.channels != 1 && transfer_.channels != 3) {
      throw error("transfer", "it has " + std::to_string(transfer_.channels) + " channels", "1 or 3");
    }
    const std::size_t values = channels() * squared(transfer_.order);
    checkTable(transfer_.vectors, mesh_.vertexCount(), values, "transfer", perVertex(values, "coefficients"));
  }

  void checkNearField() const {
    if (transfer_.near_vectors.empty()) return;
    if (!isFinite(transfer_.sphere_center) || !std::isfinite(transfer_.sphere_radius) ||
        !(transfer_.sphere_radius > 0)) {
      throw error("near field", "its sphere has no finite centre and radius", "a radius above 0");
    }
    const std::size_t values = channels() * squared(transfer_.order);
    checkTable(transfer_.near_vectors, mesh_.vertexCount(), values, "nearTransfer",
               perVertex(values, "coefficients"));
  }

  void checkNothingGlossy() const {
    const auto& t = transfer_;
    if (t.row_order == 0 && t.tangents.empty() && t.matrices.empty() && t.clusters.empty() &&
        t.basis.empty() && t.material.model == LobeModel::kNone) {
      return;
    }
    throw error("transfer", "a diffuse pack has no matrices, tangents or lobe",
                "storage none with none of them");
  }

  void checkFrames() const {
    checkCount("tangents", transfer_.tangents.size());
    for (std::size_t i = 0; i < transfer_.tangents.size(); ++i) {
      const Float4& t = transfer_.tangents[i];
      const Float3 tangent = {t[0], t[1], t[2]};
      const std::string element = "tangents, vertex " + std::to_string(i);
      if (!isUnit(tangent) || std::abs(t[3]) != 1) {
        throw error(element, "it is no unit vector with a sign", "length 1, and 1 or -1");
      }
      if (!(std::abs(dot(tangent, mesh_.normals[i])) <= kUnitTolerance)) {
        throw error(element, "it is not at right angles to the normal", "a frame of the same mesh");
      }
    }
  }

  void checkMatrices() const {
    checkOrder(transfer_.row_order, "row order of the transfer");
    const std::size_t matrix = channels() * squared(transfer_.row_order) * squared(transfer_.order);
    const char* section = matrixSection(transfer_.storage);
    if (transfer_.storage == MatrixStorage::kCpca) {
      checkClusters(matrix);
      return;
    }
    if (!transfer_.clusters.empty() || !transfer_.basis.empty()) {
      throw error("transfer", "it has clusters", "storage cpca, or none of them");
    }
    if (transfer_.storage == MatrixStorage::kMatrix) {
      checkTable(transfer_.matrices, mesh_.vertexCount(), matrix, section, perVertex(matrix, "values"));
      return;
    }
    if (transfer_.channels != 1) {
      throw error("transfer", "visibility has no colour", "1 channel", "store matrices, or cpca");
    }
    const std::size_t values = squared(transfer_.row_order + transfer_.order - 1);
    checkTable(transfer_.matrices, mesh_.vertexCount(), values, section, perVertex(values, "coefficients"));
  }

  void checkClusters(std::size_t matrix) const {
    const std::size_t weights = transfer_.matrices.columns, per_cluster = weights + 1;
    if (weights == 0) throw error("section weights", "it has no column", "one weight a vertex or more");
    checkTable(transfer_.matrices, mesh_.vertexCount(), weights, "weights", perVertex(weights, "weights"));
    if (transfer_.basis.empty() || transfer_.basis.rows % per_cluster != 0) {
      throw error("section basis", "it has " + std::to_string(transfer_.basis.rows) + " rows",
                  "a multiple of " + std::to_string(per_cluster) + ", a mean and " + std::to_string(weights) +
                      " matrices a cluster");
    }
    checkTable(transfer_.basis, transfer_.basis.rows, matrix, "basis",
               "matrices of " + std::to_string(matrix) + " values");
    checkCount("clusters", transfer_.clusters.size());
    const std::size_t count = transfer_.basis.rows / per_cluster;
    for (std::size_t i = 0; i < transfer_.clusters.size(); ++i) {
      if (transfer_.clusters[i] < count) continue;
      throw error("section clusters, vertex " + std::to_string(i),
                  "there is no cluster " + std::to_string(transfer_.clusters[i]),
                  "less than " + std::to_string(count));
    }
  }

  void checkMaterial() const {
    const GlossyMaterial& material = transfer_.material;
    if (!isReflectance(material.specular_color))
      throw error("material", "its specular colour is out of range", "0 to 1");
    if (material.model == LobeModel::kPhong &&
        !(material.exponent >= 0 && std::isfinite(material.exponent))) {
      throw error("material", "its exponent is out of range", "0 or more");
    }
    if (material.model == LobeModel::kGgx && !(material.roughness >= 0 && material.roughness <= 1)) {
      throw error("material", "its roughness is out of range", "0 to 1");
    }
    if (material.model == LobeModel::kTable) checkBrdf(material.table);
  }

  void checkBrdf(const BrdfTable& table) const {
    if (table.angles < 2 || table.angles > kMaxAngles)
      throw error("section brdf", "it has " + std::to_string(table.angles) + " angles",
                  "2 to " + std::to_string(kMaxAngles));
    if (table.order < transfer_.row_order || table.order > kMaxOrder) {
      throw error("section brdf", "its order is " + std::to_string(table.order),
                  std::to_string(transfer_.row_order) + " (the matrices' row order) to 10",
                  "project the BRDF again at that order");
    }
    const auto count = checkedProduct({static_cast<std::uint64_t>(table.angles), 3, squared(table.order)});
    if (table.values.size() != *count) {
      throw error("section brdf", "it has " + std::to_string(table.values.size()) + " values",
                  std::to_string(table.angles) + " angles × 3 × " + std::to_string(squared(table.order)));
    }
    for (std::size_t i = 0; i < table.values.size(); ++i) {
      if (!std::isfinite(table.values[i]))
        throw error("section brdf", "value " + std::to_string(i) + " is not finite", "a number");
    }
  }

  const TriangleMesh& mesh_;
  const RadianceTransfer& transfer_;
  const Pack& pack_;
  const std::string& file_;
};

}  // namespace

void checkPack(const Pack& pack, const std::string& file) {
  Checker(pack, file).check();
}

std::optional<std::uint64_t> checkedProduct(std::initializer_list<std::uint64_t> factors) {
  std::uint64_t product = 1;
  for (const std::uint64_t factor : factors) {
    if (factor != 0 && product > std::numeric_limits<std::uint64_t>::max() / factor) return std::nullopt;
    product *= factor;
  }
  return product;
}

const char* matrixSection(MatrixStorage storage) {
  switch (storage) {
    case MatrixStorage::kMatrix:
      return "matrices";
    case MatrixStorage::kVisibility:
      return "visibility";
    case MatrixStorage::kCpca:
      return "weights";
    case MatrixStorage::kNone:
      break;
  }
  throw std::logic_error("a diffuse pack has no matrices");
}

}  // namespace bakelight::formats
