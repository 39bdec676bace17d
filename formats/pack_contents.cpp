#include "formats/pack_contents.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "formats/btf_reflection.h"
#include "formats/neighborhood.h"
#include "formats/pixel_transfer.h"
#include "formats/rtt_reflection.h"
#include "formats/translucency.h"

namespace bakelight::formats {
namespace {

constexpr double kMaxAngles = 65536;
const Range kOrders{1, kMaxOrder}, kReflectance{0, 1};

std::size_t squared(int order) {
  return static_cast<std::size_t>(order) * static_cast<std::size_t>(order);
}

void describeOperator(FieldVisitor& fields, ClusteredOperator& clustered, std::size_t matrix) {
  fields.table("weights", clustered.weights, Rows::kVertex, clustered.weights.columns);
  fields.table("basis", clustered.basis, Rows::kOther, matrix);
  const std::size_t weights = clustered.weights.columns, per_cluster = weights + 1;
  fields.require(weights > 0, "weights", "it has no column", "one weight a vertex or more", "");
  fields.require(!clustered.basis.empty() && clustered.basis.rows % per_cluster == 0, "basis",
                 "it has " + std::to_string(clustered.basis.rows) + " rows",
                 "a multiple of " + std::to_string(per_cluster) + ", a mean and " + std::to_string(weights) +
                     " matrices a cluster",
                 "");
  fields.indices("clusters", clustered.clusters, clustered.basis.rows / per_cluster);
}

void describeGlossy(FieldVisitor& fields, GlossyTransfer& glossy, const ShTransfer& transfer) {
  int kind = static_cast<int>(glossy.transfer.index());
  fields.choice("operator", kind, kOperatorNames);
  if (kind != static_cast<int>(glossy.transfer.index())) {
    if (kind == 0) glossy.transfer = MatrixOperator();
    if (kind == 1) glossy.transfer = VisibilityOperator();
    if (kind == 2) glossy.transfer = ClusteredOperator();
  }
  fields.integer("outputOrder", glossy.output_order, kOrders);
  fields.tangents("tangents", glossy.tangents);
  const std::size_t matrix =
      static_cast<std::size_t>(transfer.channels) * squared(glossy.output_order) * squared(transfer.order);
  if (auto* matrices = std::get_if<MatrixOperator>(&glossy.transfer))
    fields.table("matrices", matrices->matrices, Rows::kVertex, matrix);
  if (auto* visibility = std::get_if<VisibilityOperator>(&glossy.transfer)) {
    fields.require(transfer.channels == 1, "visibility", "visibility has no colour", "1 channel",
                   "store matrices, or cpca");
    fields.table("visibility", visibility->visibility, Rows::kVertex,
                 squared(glossy.output_order + transfer.order - 1));
  }
  if (auto* clustered = std::get_if<ClusteredOperator>(&glossy.transfer))
    describeOperator(fields, *clustered, matrix);
}

// ---- permutation

class VertexPermuter final : public FieldVisitor {
 public:
  explicit VertexPermuter(std::span<const std::uint32_t> source_from_target) : order_(source_from_target) {}

  void table(const char*, EncodedTable& table, Rows rows, std::size_t) override {
    if (rows == Rows::kVertex) permute(table);
  }
  void indices(const char*, std::vector<std::uint32_t>& values, std::size_t) override { permute(values); }
  void tangents(const char*, std::vector<Float4>& values) override { permute(values); }
  bool open(const char*, bool is_there) override { return is_there; }

  // Nothing in these belongs to a vertex.
  void integer(const char*, int&, const Range&) override {}
  void number(const char*, float&, const Range&) override {}
  void constant(const char*, const char*) override {}
  void vector(const char*, Float3&, const Range&) override {}
  void choice(const char*, int&, std::span<const char* const>) override {}
  void floats(const char*, std::vector<float>&, std::size_t) override {}
  void integers(const char*, IntegerArray&, std::size_t) override {}
  void image(const char*, PackImage&) override {}
  void close() override {}
  void require(bool, const char*, const std::string&, const std::string&, const std::string&) override {}

  template <class Value>
  void permute(std::vector<Value>& values) const {
    if (values.empty()) return;
    std::vector<Value> result;
    result.reserve(order_.size());
    for (const std::uint32_t source : order_) result.push_back(values[source]);
    values = std::move(result);
  }

 private:
  void permute(EncodedTable& table) const {
    if (table.empty()) return;
    const std::size_t row_bytes = table.rowBytes();
    Bytes data(order_.size() * row_bytes);
    for (std::size_t row = 0; row < order_.size(); ++row)
      std::memcpy(data.data() + row * row_bytes, table.data.data() + order_[row] * row_bytes, row_bytes);
    table.rows = order_.size();
    table.data = std::move(data);
  }

  std::span<const std::uint32_t> order_;
};

template <class Glossy>
auto& vertexTableOf(Glossy& glossy) {
  if (auto* matrices = std::get_if<MatrixOperator>(&glossy.transfer)) return matrices->matrices;
  if (auto* visibility = std::get_if<VisibilityOperator>(&glossy.transfer)) return visibility->visibility;
  return std::get<ClusteredOperator>(glossy.transfer).weights;
}

}  // namespace

std::string namesOf(const PackPartKinds& kinds) {
  std::string text;
  for (std::size_t i = 0; i < kinds.size(); ++i)
    text += (i == 0 ? "" : i + 1 == kinds.size() ? " or " : ", ") + std::string(kinds[i].name);
  return text;
}

const EncodedTable& GlossyTransfer::vertexTable() const {
  return vertexTableOf(*this);
}

EncodedTable& GlossyTransfer::vertexTable() {
  return vertexTableOf(*this);
}

void ShTransfer::describe(FieldVisitor& fields) {
  fields.constant("basis", "real_sh_cartesian");
  fields.constant("frame", "object");
  fields.constant("inversePi", "inside");
  fields.constant("albedo", "outside");
  fields.integer("order", order, kOrders);
  choose(fields, "transport", transport, kTransports);
  fields.integer("channels", channels, {1, 3});
  fields.require(channels != 2, "channels", "it has 2 channels", "1 or 3", "");
  const std::size_t values = static_cast<std::size_t>(channels) * squared(order);
  fields.table("vectors", vectors, Rows::kVertex, values);
  optionally(fields, "nearField", near_field, [&](NearField& near) {
    fields.vector("center", near.center, {});
    fields.number("radius", near.radius, {.least = 0, .above = true});
    fields.table("nearVectors", near.vectors, Rows::kVertex, values);
  });
  optionally(fields, "glossy", glossy, [&](GlossyTransfer& part) { describeGlossy(fields, part, *this); });
}

void PhongLobe::describe(FieldVisitor& fields) {
  fields.number("exponent", exponent, {.least = 0});
  fields.vector("specularColor", specular_color, kReflectance);
}

void GgxLobe::describe(FieldVisitor& fields) {
  fields.number("roughness", roughness, {0, 1});
  fields.vector("specularColor", specular_color, kReflectance);
}

void BrdfTable::describe(FieldVisitor& fields) {
  fields.integer("angles", angles, {2, kMaxAngles});
  fields.integer("order", order, kOrders);
  fields.floats("brdf", values, static_cast<std::size_t>(angles) * 3 * squared(order));
}

PackPartKinds& transferKinds() {
  static PackPartKinds kinds = {PackPartKind::of<ShTransfer>(), PackPartKind::of<PixelTransfer>()};
  return kinds;
}

PackPartKinds& reflectionKinds() {
  static PackPartKinds kinds = {PackPartKind::of<LambertReflection>(), PackPartKind::of<PhongLobe>(),
                                PackPartKind::of<GgxLobe>(),           PackPartKind::of<BrdfTable>(),
                                PackPartKind::of<RttReflection>(),     PackPartKind::of<BtfReflection>(),
                                PackPartKind::of<Translucency>()};
  return kinds;
}

PackPartKinds& neighborhoodKinds() {
  static PackPartKinds kinds = {PackPartKind::of<Neighborhood>()};
  return kinds;
}

ShTransfer& Pack::sh() {
  auto* result = transfer.as<ShTransfer>();
  if (result == nullptr)
    throw std::invalid_argument(std::string("the pack's transfer is of kind ") + transfer.kind() +
                                ", not sh");
  return *result;
}

const ShTransfer& Pack::sh() const {
  return const_cast<Pack*>(this)->sh();
}

std::vector<VertexRange> appearanceRanges(const Pack& pack) {
  const TriangleMesh& mesh = pack.mesh;
  std::vector<VertexRange> ranges(pack.appearances.size());
  if (ranges.size() == 1) {
    ranges[0] = {0, mesh.vertexCount()};
    return ranges;
  }
  if (mesh.triangle_materials.size() != mesh.triangleCount())
    throw std::invalid_argument("a pack of several appearances tells that of each triangle");
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  for (VertexRange& range : ranges) range.first = kNone;
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
    VertexRange& range = ranges.at(mesh.triangle_materials[t]);
    for (const std::uint32_t v : mesh.triangles[t]) {
      range.first = std::min<std::size_t>(range.first, v);
      range.end = std::max<std::size_t>(range.end, v + 1);
    }
  }
  std::size_t end = 0;
  for (VertexRange& range : ranges) {
    if (range.first == kNone) range = {end, end};
    if (range.first < end) throw std::invalid_argument("vertices are not in the order of their appearances");
    range.first = end;
    end = range.end;
  }
  ranges.back().end = mesh.vertexCount();
  return ranges;
}

void permuteVertices(Pack& pack, std::span<const std::uint32_t> source_from_target) {
  VertexPermuter permuter(source_from_target);
  permuter.permute(pack.mesh.positions);
  permuter.permute(pack.mesh.normals);
  permuter.permute(pack.mesh.texcoords);
  permuter.permute(pack.mesh.colors);
  permuter.permute(pack.colors);
  pack.transfer.describe(permuter);
  for (Appearance& appearance : pack.appearances) appearance.reflection.describe(permuter);
  if (pack.neighborhood) pack.neighborhood->describe(permuter);
}

}  // namespace bakelight::formats
