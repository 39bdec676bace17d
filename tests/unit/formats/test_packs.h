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

#include "formats/field_list.h"
#include "formats/pack.h"
#include "tests/support/pack_parts.h"
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
  Pack pack{.name = "grid", .mesh = std::move(mesh)};
  pack.appearances.front().base_color = {0.25F, 0.5F, 0.75F};
  pack.sh().order = order;
  pack.sh().vectors = tableOver(pack.mesh, static_cast<std::size_t>(order * order), Precision::kFloat32, 0);
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

inline PackPart lobeOf(Lobe lobe, int output_order) {
  constexpr Float3 kSpecular = {0.1F, 0.2F, 0.3F};
  if (lobe == Lobe::kPhong) return PhongLobe{12.3F, kSpecular};
  if (lobe == Lobe::kGgx) return GgxLobe{0.37F, kSpecular};
  if (lobe == Lobe::kNone) return LambertReflection();
  BrdfTable table{4, output_order + 1, {}};
  const int count = 4 * 3 * (output_order + 1) * (output_order + 1);
  for (int i = 0; i < count; ++i) table.values.push_back(0.01F * static_cast<float>(i - 7));
  return table;
}

// Order 2, rows of order 3: not square, so that exchanged sizes show. Three channels except for visibility,
// near field, vertex colours; two clusters of two weights.
inline Pack glossyPack(TriangleMesh mesh, Storage storage, Precision precision, Lobe lobe) {
  constexpr int kOrder = 2, kOutputOrder = 3;
  constexpr std::size_t kCoefficients = 4, kRows = 9;
  Pack pack = diffusePack(std::move(mesh), kOrder);
  ShTransfer& transfer = pack.sh();
  transfer.transport = Transport::kInterreflected;
  transfer.channels = storage == Storage::kVisibility ? 1 : 3;
  const auto channels = static_cast<std::size_t>(transfer.channels);
  transfer.vectors = tableOver(pack.mesh, channels * kCoefficients, Precision::kFloat32, 1);
  transfer.near_field = {
      {0.1F, -0.2F, 0.3F}, 1.7F, tableOver(pack.mesh, channels * kCoefficients, Precision::kFloat32, 2)};
  GlossyTransfer& glossy = transfer.glossy.emplace();
  glossy.output_order = kOutputOrder;
  glossy.tangents = tangentsOf(pack.mesh);
  const std::size_t matrix = channels * kRows * kCoefficients;
  if (storage == Storage::kMatrix)
    glossy.transfer = MatrixOperator{tableOver(pack.mesh, matrix, precision, 3)};
  if (storage == Storage::kVisibility)
    glossy.transfer = VisibilityOperator{tableOver(pack.mesh, 16, precision, 4)};
  if (storage == Storage::kCpca) {
    std::vector<float> basis;
    for (std::size_t i = 0; i < 2 * 3 * matrix; ++i) basis.push_back(0.25F * static_cast<float>(i % 101) - 7);
    ClusteredOperator clustered{
        tableOver(pack.mesh, 2, precision, 5), {}, encodeTable(basis, matrix, precision, "test", "basis")};
    for (std::size_t i = 0; i < pack.mesh.vertexCount(); ++i)
      clustered.clusters.push_back(pack.mesh.positions[i][0] < 0.4F ? 0 : 1);
    glossy.transfer = std::move(clustered);
  }
  pack.appearances.front().reflection = lobeOf(lobe, kOutputOrder);
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

inline void expectSameReflection(const PackPart& read, const PackPart& source) {
  ASSERT_STREQ(read.kind(), source.kind());
  const std::vector<FieldValue> a = fieldsOf(read), b = fieldsOf(source);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].plain, b[i].plain) << a[i].name;
    EXPECT_EQ(a[i].values, b[i].values) << a[i].name;
  }
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
  ASSERT_EQ(read.appearances.size(), source.appearances.size());
  for (std::size_t i = 0; i < read.appearances.size(); ++i) {
    EXPECT_EQ(read.appearances[i].material, source.appearances[i].material);
    EXPECT_EQ(read.appearances[i].base_color, source.appearances[i].base_color);
    expectSameReflection(read.appearances[i].reflection, source.appearances[i].reflection);
  }
  expectSameRows(read.mesh.normals, source.mesh.normals, source_of);
  std::vector<Float2> texcoords = source.mesh.texcoords;
  for (Float2& t : texcoords) t[1] = 1 - (1 - t[1]);  // v is stored as 1 − v, which may round
  expectSameRows(read.mesh.texcoords, texcoords, source_of);
  expectSameRows(read.colors, source.colors, source_of);
  const ShTransfer &a = read.sh(), &b = source.sh();
  EXPECT_EQ(a.order, b.order);
  EXPECT_EQ(a.transport, b.transport);
  EXPECT_EQ(a.channels, b.channels);
  expectSameTable(a.vectors, b.vectors, source_of);
  ASSERT_EQ(a.near_field.has_value(), b.near_field.has_value());
  if (a.near_field) {
    expectSameTable(a.near_field->vectors, b.near_field->vectors, source_of);
    EXPECT_EQ(a.near_field->center, b.near_field->center);
    EXPECT_EQ(a.near_field->radius, b.near_field->radius);
  }
  ASSERT_EQ(a.glossy.has_value(), b.glossy.has_value());
  if (!a.glossy) return;
  EXPECT_STREQ(a.glossy->operatorName(), b.glossy->operatorName());
  EXPECT_EQ(a.glossy->output_order, b.glossy->output_order);
  expectSameRows(a.glossy->tangents, b.glossy->tangents, source_of);
  expectSameTable(a.glossy->vertexTable(), b.glossy->vertexTable(), source_of);
  if (const auto* clusters = std::get_if<ClusteredOperator>(&a.glossy->transfer)) {
    const auto& expected = std::get<ClusteredOperator>(b.glossy->transfer);
    expectSameRows(clusters->clusters, expected.clusters, source_of);
    EXPECT_EQ(clusters->basis.data, expected.basis.data);
    EXPECT_EQ(clusters->basis.rows, expected.basis.rows);
    EXPECT_EQ(clusters->basis.columns, expected.basis.columns);
    EXPECT_EQ(clusters->basis.precision, expected.basis.precision);
    EXPECT_EQ(clusters->basis.scale, expected.basis.scale);
    EXPECT_EQ(clusters->basis.offset, expected.basis.offset);
  }
}

inline void setByte(EncodedTable& table, std::size_t i, std::byte value) {
  Bytes bytes(table.data.begin(), table.data.end());
  bytes[i] = value;
  table.data = std::move(bytes);
}

inline Pack roundTrip(const Pack& pack, const PackOptions& options) {
  return decodePack(encodePack(pack, options, "a.glb"), "a.glb");
}

}  // namespace bakelight::formats
