#include "tests/e2e/made_packs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <Eigen/Dense>
#include <numbers>
#include <span>

#include "transport/directions.h"
#include "transport/sh.h"
#include "transport/triple_product.h"
#include "transport/vector_types.h"

namespace bakelight::tests {
namespace {

using formats::TriangleMesh;
using transport::Vec3;

// Latitude rings from the north pole; quads at the poles shrink to triangles with a repeated position.
template <class Radius>
void addBall(TriangleMesh& mesh, int rings, const Vec3& center, const Radius& radius) {
  const int columns = 2 * rings;
  const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
  for (int ring = 0; ring <= rings; ++ring)
    for (int column = 0; column < columns; ++column) {
      const double polar = std::numbers::pi * ring / rings, azimuth = 2 * std::numbers::pi * column / columns;
      const Vec3 direction(std::sin(polar) * std::sin(azimuth), std::cos(polar),
                           std::sin(polar) * std::cos(azimuth));
      mesh.positions.push_back(transport::float3(center + radius(polar, azimuth) * direction));
    }
  const auto index = [&](int ring, int column) {
    return first + static_cast<std::uint32_t>(ring * columns + column % columns);
  };
  for (int ring = 0; ring < rings; ++ring)
    for (int column = 0; column < columns; ++column) {
      const auto a = index(ring, column), b = index(ring + 1, column), c = index(ring + 1, column + 1),
                 d = index(ring, column + 1);
      if (ring + 1 < rings) mesh.triangles.push_back({a, b, c});
      if (ring > 0) mesh.triangles.push_back({a, c, d});
    }
}

void setNormals(TriangleMesh& mesh) {
  std::vector<Vec3> sums(mesh.vertexCount(), Vec3::Zero());
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 origin = transport::vec3(mesh.positions[a]);
    const Vec3 doubled_area =
        (transport::vec3(mesh.positions[b]) - origin).cross(transport::vec3(mesh.positions[c]) - origin);
    for (const auto vertex : {a, b, c}) sums[vertex] += doubled_area;
  }
  mesh.normals.clear();
  for (const Vec3& sum : sums)
    mesh.normals.push_back(transport::float3(sum.squaredNorm() > 0 ? Vec3(sum.normalized()) : Vec3::UnitY()));
}

formats::EncodedTable tableOf(const std::vector<float>& values, std::size_t columns,
                              formats::Precision precision = formats::Precision::kFloat32) {
  return formats::encodeTable(values, columns, precision, "made", "table");
}

formats::Pack packOf(TriangleMesh mesh, int order) {
  formats::Pack pack;
  pack.name = "made";
  pack.mesh = std::move(mesh);
  pack.sh().order = order;
  pack.sh().transport = formats::Transport::kUnshadowed;
  std::vector<float> vectors;
  const auto factors = transport::clampedCosineFactors(order);
  for (const auto& normal : pack.mesh.normals) {
    const auto basis = transport::evaluateSh(order, transport::vec3(normal).normalized());
    for (int l = 0; l < order; ++l)
      for (int m = -l; m <= l; ++m)
        vectors.push_back(
            static_cast<float>(factors[l] / std::numbers::pi * basis[transport::coefficientIndex(l, m)]));
  }
  pack.sh().vectors = tableOf(vectors, transport::coefficientCount(order));
  return pack;
}

// Any tangent, and every third frame left-handed.
formats::Float4 tangentOf(const Vec3& normal, std::size_t vertex) {
  const Vec3 helper = std::abs(normal.y()) < 0.9 ? Vec3::UnitY() : Vec3::UnitX();
  const Vec3 tangent = helper.cross(normal).normalized();
  return {static_cast<float>(tangent.x()), static_cast<float>(tangent.y()), static_cast<float>(tangent.z()),
          vertex % 3 == 0 ? -1.0F : 1.0F};
}

// Columns t, b, n.
Eigen::Matrix3d objectFromLocal(const formats::Pack& pack, std::size_t vertex) {
  const auto& tangent = pack.sh().glossy->tangents[vertex];
  const Vec3 n = transport::vec3(pack.mesh.normals[vertex]).normalized();
  const Vec3 t(tangent[0], tangent[1], tangent[2]);
  Eigen::Matrix3d frame;
  frame << t, tangent[3] * n.cross(t), n;
  return frame;
}

// Basis functions at many directions, a row each; for changes of frame by solving for coefficients, which
// needs no rotation matrices and takes reflections, too.
class FrameChange {
 public:
  explicit FrameChange(int order)
      : order_(order), directions_(transport::sphereDirections(6 * transport::coefficientCount(order))) {
    inverse_ = basisAt(Eigen::Matrix3d::Identity()).completeOrthogonalDecomposition().pseudoInverse();
  }
  // Local coefficients = result × object coefficients.
  Eigen::MatrixXd localFromObject(const Eigen::Matrix3d& object_from_local) const {
    return inverse_ * basisAt(object_from_local);
  }

 private:
  Eigen::MatrixXd basisAt(const Eigen::Matrix3d& turn) const {
    Eigen::MatrixXd basis(directions_.size(), transport::coefficientCount(order_));
    for (std::size_t d = 0; d < directions_.size(); ++d) {
      const auto values = transport::evaluateSh(order_, turn * directions_[d]);
      for (Eigen::Index i = 0; i < basis.cols(); ++i) basis(d, i) = values[i];
    }
    return basis;
  }

  int order_;
  std::vector<Vec3> directions_;
  Eigen::MatrixXd inverse_;
};

std::vector<float> hemisphereVisibility(const formats::Pack& pack, int order) {
  const auto zonal = transport::diskLightZonal(order, std::numbers::pi / 2);
  std::vector<float> visibility;
  for (const auto& normal : pack.mesh.normals)
    for (const double value : transport::orientZonal(zonal, transport::vec3(normal).normalized()))
      visibility.push_back(static_cast<float>(value));
  return visibility;
}

std::vector<float> hemisphereMatrices(const formats::Pack& pack, int row_order, int channels) {
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const transport::TripleProduct product(row_order, pack.sh().order);
  const int rows = transport::coefficientCount(row_order),
            columns = transport::coefficientCount(pack.sh().order);
  const std::size_t visibility_count = transport::coefficientCount(product.visibilityOrder());
  const auto visibility = hemisphereVisibility(pack, product.visibilityOrder());
  const FrameChange change(row_order);
  constexpr std::array<double, 3> kTint = {1, 0.8, 0.6};
  std::vector<float> matrices;
  for (std::size_t v = 0; v < pack.mesh.vertexCount(); ++v) {
    RowMajor object(rows, columns);
    product.matrixOf(std::span(visibility).subspan(v * visibility_count, visibility_count),
                     {object.data(), static_cast<std::size_t>(object.size())});
    const Eigen::MatrixXd local = change.localFromObject(objectFromLocal(pack, v)) * object.cast<double>();
    for (int channel = 0; channel < channels; ++channel) {
      const RowMajor tinted = (channels == 3 ? kTint[channel] * local : local).cast<float>();
      matrices.insert(matrices.end(), tinted.data(), tinted.data() + tinted.size());
    }
  }
  return matrices;
}

// Eight clusters by octant, two components, all smooth made-up numbers.
void addClusters(formats::Pack& pack, int row_order, int channels) {
  constexpr std::size_t kClusters = 8, kComponents = 2;
  formats::ShTransfer& transfer = pack.sh();
  const std::size_t size = static_cast<std::size_t>(channels) * transport::coefficientCount(row_order) *
                           transport::coefficientCount(transfer.order);
  std::vector<float> weights, basis;
  for (const auto& normal : pack.mesh.normals) {
    clustersOf(transfer).clusters.push_back((normal[0] > 0 ? 1U : 0U) + (normal[1] > 0 ? 2U : 0U) +
                                            (normal[2] > 0 ? 4U : 0U));
    weights.insert(weights.end(), {normal[0], normal[1] * normal[2]});
  }
  for (std::size_t row = 0; row < kClusters * (1 + kComponents); ++row)
    for (std::size_t i = 0; i < size; ++i)
      basis.push_back(
          static_cast<float>(0.3 * std::sin(0.7 * static_cast<double>(row) + 0.37 * static_cast<double>(i)) +
                             (row % 3 == 0 && i % (size / channels) == 0 ? 0.8 : 0)));
  transfer.glossy->vertexTable() = tableOf(weights, kComponents);
  clustersOf(transfer).basis = tableOf(basis, size);
}

}  // namespace

formats::Pack spherePack(int order, int rings) {
  TriangleMesh mesh;
  addBall(mesh, rings, Vec3::Zero(), [](double, double) { return 1.0; });
  mesh.normals = mesh.positions;
  return packOf(std::move(mesh), order);
}

formats::Pack wavyPack(int order, int rings) {
  const Vec3 center(3, -2, 5);
  TriangleMesh mesh;
  addBall(mesh, rings, center, [](double polar, double azimuth) {
    return 1 + 0.12 * std::sin(3 * polar) * std::sin(3 * polar) * std::cos(5 * azimuth);
  });
  addBall(mesh, rings / 2, center + Vec3(0.7, 0.35, 1.1), [](double, double) { return 0.25; });
  setNormals(mesh);
  formats::Pack pack = packOf(std::move(mesh), order);
  pack.appearances[0].base_color = {0.9f, 0.6f, 0.3f};
  return pack;
}

void addGlossyTransfer(formats::Pack& pack, int row_order, formats::Storage storage, int channels) {
  formats::ShTransfer& transfer = pack.sh();
  makeGlossy(transfer, storage, row_order);
  for (std::size_t v = 0; v < pack.mesh.vertexCount(); ++v)
    transfer.glossy->tangents.push_back(tangentOf(transport::vec3(pack.mesh.normals[v]).normalized(), v));
  if (channels == 3 && transfer.channels == 1) {
    const std::vector<float> one = transfer.vectors.decode();
    const std::size_t columns = transfer.vectors.columns;
    std::vector<float> three;
    for (std::size_t v = 0; v < pack.mesh.vertexCount(); ++v)
      for (const float tint : {1.0F, 0.7F, 0.5F})
        for (std::size_t i = 0; i < columns; ++i) three.push_back(tint * one[v * columns + i]);
    transfer.vectors = tableOf(three, 3 * columns);
    transfer.channels = 3;
  }
  const int visibility_order = row_order + transfer.order - 1;
  if (storage == formats::Storage::kMatrix) {
    const auto matrices = hemisphereMatrices(pack, row_order, channels);
    transfer.glossy->vertexTable() = tableOf(matrices, matrices.size() / pack.mesh.vertexCount());
  } else if (storage == formats::Storage::kVisibility) {
    transfer.glossy->vertexTable() =
        tableOf(hemisphereVisibility(pack, visibility_order), transport::coefficientCount(visibility_order));
  } else {
    addClusters(pack, row_order, channels);
  }
}

void encodeAt(formats::Precision precision, formats::Pack& pack) {
  formats::ShTransfer& transfer = pack.sh();
  std::vector<formats::EncodedTable*> tables = {&transfer.vectors};
  if (transfer.near_field) tables.push_back(&transfer.near_field->vectors);
  if (transfer.glossy) tables.push_back(&transfer.glossy->vertexTable());
  if (storageOf(transfer) == formats::Storage::kCpca) tables.push_back(&clustersOf(transfer).basis);
  for (formats::EncodedTable* table : tables) *table = tableOf(table->decode(), table->columns, precision);
}

formats::BrdfTable madeBrdfTable(int angles, int order) {
  formats::BrdfTable table{angles, order, {}};
  for (int angle = 0; angle < angles; ++angle)
    for (int channel = 0; channel < 3; ++channel)
      for (int l = 0; l < order; ++l)
        for (int m = -l; m <= l; ++m)
          table.values.push_back(
              m < 0 ? 0.0F
                    : static_cast<float>(0.6 * std::cos(0.9 * l + 0.5 * m + 0.2 * angle + channel) /
                                         (1 + l + m)));
  return table;
}

void addNearTransfer(formats::Pack& pack, float radius) {
  constexpr int kDirections = 4096;
  const auto directions = transport::sphereDirections(kDirections);
  const int count = transport::coefficientCount(pack.sh().order);
  std::vector<std::vector<double>> basis;
  for (const Vec3& direction : directions) basis.push_back(transport::evaluateSh(pack.sh().order, direction));
  std::vector<float> vectors;
  for (std::size_t v = 0; v < pack.mesh.vertexCount(); ++v) {
    const Vec3 position = transport::vec3(pack.mesh.positions[v]);
    const Vec3 normal = transport::vec3(pack.mesh.normals[v]).normalized();
    std::vector<double> vector(count, 0.0);
    for (int d = 0; d < kDirections; ++d) {
      // A patch R² dω of the sphere's inside lights the vertex by dω R² cos θ_patch / r².
      const Vec3 to_patch = radius * directions[d] - position;
      const double distance = to_patch.norm();
      const double cosine = std::max(normal.dot(to_patch) / distance, 0.0);
      const double patch_cosine = directions[d].dot(to_patch) / distance;
      const double weight = 4 * std::numbers::pi / kDirections / std::numbers::pi * cosine * patch_cosine *
                            radius * radius / (distance * distance);
      for (int i = 0; i < count; ++i) vector[i] += weight * basis[d][i];
    }
    vectors.insert(vectors.end(), vector.begin(), vector.end());
  }
  pack.sh().near_field = {{0, 0, 0}, radius, tableOf(vectors, count)};
}

void scaleMesh(formats::Pack& pack, float factor) {
  for (auto& position : pack.mesh.positions)
    for (float& value : position) value *= factor;
}

}  // namespace bakelight::tests
