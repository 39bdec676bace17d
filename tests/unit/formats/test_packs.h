// Small packs whose tables are functions of where a vertex is, so that they can be checked after any
// reordering.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "formats/pack.h"
#include "tests/unit/formats/test_meshes.h"

namespace bakelight::formats {

inline float coefficient(const Float3& position, std::size_t i) {
  const auto k = static_cast<float>(i);
  return position[0] * (k + 1) + position[1] - 2 * position[2] * k;
}

inline EncodedTable tableOver(const TriangleMesh& mesh, std::size_t columns, Precision precision,
                              std::size_t shift) {
  std::vector<float> values;
  for (const Float3& position : mesh.positions) {
    for (std::size_t i = 0; i < columns; ++i) values.push_back(coefficient(position, i + shift));
  }
  return encodeTable(values, columns, precision, "test", "table");
}

// Transfer at `order` in plain floats, as a pack of version 1 has it.
inline Pack diffusePack(TriangleMesh mesh, int order) {
  Pack pack{"grid", std::move(mesh), {0.25F, 0.5F, 0.75F}, {}, {}};
  pack.transfer.order = order;
  pack.transfer.vectors =
      tableOver(pack.mesh, static_cast<std::size_t>(order * order), Precision::kFloat32, 0);
  return pack;
}

// Unit, at right angles to the normal; both signs occur.
inline std::vector<Float4> tangentsOf(const TriangleMesh& mesh) {
  std::vector<Float4> tangents;
  for (const Float3& n : mesh.normals) {
    const Float3 t = {1 - n[0] * n[0], -n[0] * n[1], -n[0] * n[2]};
    const float length = std::hypot(t[0], t[1], t[2]);
    tangents.push_back(
        {t[0] / length, t[1] / length, t[2] / length, tangents.size() % 3 == 0 ? -1.0F : 1.0F});
  }
  return tangents;
}

inline GlossyMaterial lobeOf(LobeModel model, int row_order) {
  GlossyMaterial material;
  material.model = model;
  if (model == LobeModel::kPhong) material.exponent = 12.3F;
  if (model == LobeModel::kGgx) material.roughness = 0.37F;
  if (model == LobeModel::kPhong || model == LobeModel::kGgx) material.specular_color = {0.1F, 0.2F, 0.3F};
  if (model == LobeModel::kTable) {
    material.table = {4, row_order + 1, {}};
    const int count = 4 * 3 * (row_order + 1) * (row_order + 1);
    for (int i = 0; i < count; ++i) material.table.values.push_back(0.01F * static_cast<float>(i - 7));
  }
  return material;
}

// Order 2, rows of order 3: not square, so that exchanged sizes show. Three channels except for visibility,
// near field, vertex colours; two clusters of two weights.
inline Pack glossyPack(TriangleMesh mesh, MatrixStorage storage, Precision precision, LobeModel lobe) {
  constexpr int kOrder = 2, kRowOrder = 3;
  constexpr std::size_t kCoefficients = 4, kRows = 9;
  Pack pack = diffusePack(std::move(mesh), kOrder);
  RadianceTransfer& transfer = pack.transfer;
  transfer.transport = "interreflected";
  transfer.channels = storage == MatrixStorage::kVisibility ? 1 : 3;
  const auto channels = static_cast<std::size_t>(transfer.channels);
  transfer.vectors = tableOver(pack.mesh, channels * kCoefficients, Precision::kFloat32, 1);
  transfer.near_vectors = tableOver(pack.mesh, channels * kCoefficients, Precision::kFloat32, 2);
  transfer.sphere_center = {0.1F, -0.2F, 0.3F};
  transfer.sphere_radius = 1.7F;
  transfer.storage = storage;
  transfer.row_order = kRowOrder;
  transfer.tangents = tangentsOf(pack.mesh);
  const std::size_t matrix = channels * kRows * kCoefficients;
  if (storage == MatrixStorage::kMatrix) transfer.matrices = tableOver(pack.mesh, matrix, precision, 3);
  if (storage == MatrixStorage::kVisibility) transfer.matrices = tableOver(pack.mesh, 16, precision, 4);
  if (storage == MatrixStorage::kCpca) {
    transfer.matrices = tableOver(pack.mesh, 2, precision, 5);
    std::vector<float> basis;
    for (std::size_t i = 0; i < 2 * 3 * matrix; ++i) basis.push_back(0.25F * static_cast<float>(i % 101) - 7);
    transfer.basis = encodeTable(basis, matrix, precision, "test", "basis");
    for (std::size_t i = 0; i < pack.mesh.vertexCount(); ++i)
      transfer.clusters.push_back(pack.mesh.positions[i][0] < 0.4F ? 0 : 1);
  }
  transfer.material = lobeOf(lobe, kRowOrder);
  for (const Float3& position : pack.mesh.positions) pack.colors.push_back({position[0], -position[2], 0.5F});
  return pack;
}

inline std::vector<std::byte> rowOf(const EncodedTable& table, std::size_t row) {
  const auto begin = table.data.begin() + static_cast<std::ptrdiff_t>(row * table.rowBytes());
  return {begin, begin + static_cast<std::ptrdiff_t>(table.rowBytes())};
}

inline void expectSameTable(const EncodedTable& read, const EncodedTable& source,
                            const std::vector<std::size_t>& source_of) {
  EXPECT_EQ(read.precision, source.precision);
  EXPECT_EQ(read.columns, source.columns);
  EXPECT_EQ(read.scale, source.scale);
  EXPECT_EQ(read.offset, source.offset);
  ASSERT_EQ(read.rows, source.empty() ? 0 : source_of.size());
  ASSERT_EQ(read.data.size(), read.rows * read.rowBytes());
  for (std::size_t i = 0; i < read.rows; ++i)
    ASSERT_EQ(rowOf(read, i), rowOf(source, source_of[i])) << "row " << i;
}

template <class Value>
void expectSameRows(const std::vector<Value>& read, const std::vector<Value>& source,
                    const std::vector<std::size_t>& source_of) {
  ASSERT_EQ(read.size(), source.empty() ? 0 : source_of.size());
  for (std::size_t i = 0; i < read.size(); ++i) ASSERT_EQ(read[i], source[source_of[i]]) << "row " << i;
}

inline void expectSameMaterial(const GlossyMaterial& read, const GlossyMaterial& source) {
  EXPECT_EQ(read.model, source.model);
  EXPECT_EQ(read.exponent, source.exponent);
  EXPECT_EQ(read.roughness, source.roughness);
  EXPECT_EQ(read.specular_color, source.specular_color);
  EXPECT_EQ(read.table.angles, source.table.angles);
  EXPECT_EQ(read.table.order, source.table.order);
  EXPECT_EQ(read.table.values, source.table.values);
}

// Each vertex of `read` carries, bit for bit, what the vertex of `source` at the same position has. Positions
// of `source` must differ.
inline void expectSamePack(const Pack& read, const Pack& source) {
  std::map<Float3, std::size_t> vertex_at;
  for (std::size_t i = 0; i < source.mesh.vertexCount(); ++i) vertex_at[source.mesh.positions[i]] = i;
  ASSERT_EQ(vertex_at.size(), source.mesh.vertexCount());
  ASSERT_GT(read.mesh.vertexCount(), 0U);
  std::vector<std::size_t> source_of;
  for (const Float3& position : read.mesh.positions) {
    ASSERT_TRUE(vertex_at.contains(position));
    source_of.push_back(vertex_at.at(position));
  }
  EXPECT_EQ(read.name, source.name);
  EXPECT_EQ(read.base_color, source.base_color);
  expectSameRows(read.mesh.normals, source.mesh.normals, source_of);
  std::vector<Float2> texcoords = source.mesh.texcoords;
  for (Float2& t : texcoords) t[1] = 1 - (1 - t[1]);  // v is stored as 1 − v, which may round
  expectSameRows(read.mesh.texcoords, texcoords, source_of);
  expectSameRows(read.colors, source.colors, source_of);
  const RadianceTransfer &a = read.transfer, &b = source.transfer;
  EXPECT_EQ(a.order, b.order);
  EXPECT_EQ(a.transport, b.transport);
  EXPECT_EQ(a.channels, b.channels);
  expectSameTable(a.vectors, b.vectors, source_of);
  expectSameTable(a.near_vectors, b.near_vectors, source_of);
  EXPECT_EQ(a.sphere_center, b.sphere_center);
  EXPECT_EQ(a.sphere_radius, b.sphere_radius);
  EXPECT_EQ(a.storage, b.storage);
  EXPECT_EQ(a.row_order, b.row_order);
  expectSameRows(a.tangents, b.tangents, source_of);
  expectSameTable(a.matrices, b.matrices, source_of);
  expectSameRows(a.clusters, b.clusters, source_of);
  EXPECT_EQ(a.basis.data, b.basis.data);
  EXPECT_EQ(a.basis.rows, b.basis.rows);
  EXPECT_EQ(a.basis.columns, b.basis.columns);
  EXPECT_EQ(a.basis.precision, b.basis.precision);
  EXPECT_EQ(a.basis.scale, b.basis.scale);
  EXPECT_EQ(a.basis.offset, b.basis.offset);
  expectSameMaterial(a.material, b.material);
}

inline Pack roundTrip(const Pack& pack, const PackOptions& options) {
  return decodePack(encodePack(pack, options, "a.glb"), "a.glb");
}

}  // namespace bakelight::formats
