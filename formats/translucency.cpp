#include "formats/translucency.h"

#include <algorithm>
#include <stdexcept>

namespace bakelight::formats {
namespace {

constexpr int kMostTexels = 16384;  // of a side

// What is wrong with a list that must not go beyond `end`; empty if nothing is.
std::string beyond(const IntegerArray& values, std::size_t end) {
  if (values.count() > 0 && values.width != 4)
    return "its values have " + std::to_string(values.width) + " bytes";
  const auto words = wordsOf(values);
  const auto stray = std::find_if(words.begin(), words.end(), [&](std::uint32_t v) { return v >= end; });
  if (stray == words.end()) return "";
  return "value " + std::to_string(stray - words.begin()) + " is " + std::to_string(*stray);
}

bool ascends(const IntegerArray& values) {
  const auto words = wordsOf(values);
  return std::adjacent_find(words.begin(), words.end(), std::greater_equal<>()) == words.end();
}

void describeIndices(FieldVisitor& fields, const char* name, IntegerArray& values, std::size_t count,
                     std::size_t end) {
  fields.integers(name, values, count);
  const std::string stray = beyond(values, end);
  fields.require(stray.empty(), name, stray, "4 bytes, below " + std::to_string(end), "");
}

}  // namespace

IntegerArray integersOf(std::span<const std::uint32_t> values) {
  const auto bytes = std::as_bytes(values);
  return {4, Bytes(bytes.begin(), bytes.end())};
}

std::span<const std::uint32_t> wordsOf(const IntegerArray& integers) {
  if (integers.count() > 0 && integers.width != 4)
    throw std::invalid_argument("integers of another width than 4 bytes");
  return {reinterpret_cast<const std::uint32_t*>(integers.data.data()), integers.count()};
}

std::span<const std::uint32_t> SparseRows::endsOf() const {
  return wordsOf(ends);
}
std::span<const std::uint32_t> SparseRows::columnsOf() const {
  return wordsOf(columns);
}

void SparseRows::describe(FieldVisitor& fields, const char* name, std::size_t value_columns,
                          std::size_t end_column) {
  if (!fields.open(name, true)) return;
  fields.integers("ends", ends, ends.count());
  const auto row_ends = ends.width == 4 ? endsOf() : std::span<const std::uint32_t>();
  fields.require(ends.count() == 0 || std::is_sorted(row_ends.begin(), row_ends.end()), "ends",
                 "they do not ascend", "where each row ends among the entries, in 4 bytes", "");
  describeIndices(fields, "columns", columns, row_ends.empty() ? 0 : row_ends.back(), end_column);
  fields.table("values", values, Rows::kOther, value_columns);
  fields.require(values.rows == columns.count(), "values", "there are " + std::to_string(values.rows),
                 std::to_string(columns.count()) + ", as many as columns", "");
  fields.close();
}

void Translucency::describe(FieldVisitor& fields) {
  constexpr int kMany = std::numeric_limits<int>::max();
  fields.integer("resolution", resolution, {1, kMostTexels});
  fields.number("eta", eta, {1, 3});
  fields.number("areaUnit", area_unit, {0, std::numeric_limits<float>::max(), true});
  if (fields.open("fallback", true)) {
    constexpr float kMost = std::numeric_limits<float>::max();
    fields.vector("reflectance", fallback.reflectance, {0, 1});
    fields.number("transmission", fallback.transmission, {0, 1});
    fields.vector("transmissionColor", fallback.transmission_color, {0, 1});
    fields.vector("attenuation", fallback.attenuation, {0, kMost});
    fields.number("thickness", fallback.thickness, {0, kMost});
    fields.close();
  }
  fields.integer("knotCount", knot_count, {1, kMany});
  fields.indices("knots", knots, static_cast<std::size_t>(knot_count));

  const auto knot_end = static_cast<std::size_t>(knot_count);
  describeIndices(fields, "texels", texels, texels.count(),
                  static_cast<std::size_t>(resolution) * resolution);
  fields.require(ascends(texels), "texels", "they do not ascend", "row by row from the top", "");
  describeIndices(fields, "texelKnots", texel_knots, 3 * texels.count(), knot_end);
  const auto perTexel = [&](const char* name, EncodedTable& table, std::size_t columns) {
    fields.table(name, table, Rows::kOther, columns);
    fields.require(table.rows == texels.count(), name, "it has " + std::to_string(table.rows) + " rows",
                   std::to_string(texels.count()) + ", one a texel", "");
  };
  perTexel("texelWeights", texel_weights, 2);
  perTexel("areas", areas, 1);
  perTexel("blend", blend, 9);

  describeIndices(fields, "receivers", receivers, receivers.count(), texels.count());
  fields.require(ascends(receivers), "receivers", "they do not ascend", "in the order of texels", "");
  fields.integer("components", components, {0, 3 * kKernelTexels});
  const std::size_t values = std::size_t{3} * kKernelTexels;
  fields.table("kernels", kernels, Rows::kOther,
               components > 0 ? static_cast<std::size_t>(components) : values);
  fields.require(kernels.rows == receivers.count(), "kernels",
                 "it has " + std::to_string(kernels.rows) + " rows",
                 std::to_string(receivers.count()) + ", one a receiver", "");
  if (components > 0) fields.floats("basis", basis, static_cast<std::size_t>(components) * values);

  const auto hasRows = [&](const char* name, const SparseRows& matrix, std::size_t rows) {
    fields.require(matrix.rows() == rows, name, "it has " + std::to_string(matrix.rows()) + " rows",
                   std::to_string(rows), "");
  };
  sharpen.describe(fields, "sharpen", 1, knot_end);
  near.describe(fields, "near", 3, knot_end);
  hasRows("sharpen", sharpen, knot_end);
  hasRows("near", near, knot_end);
  if (!fields.open("far", far_count > 0)) return;
  fields.integer("count", far_count, {1, kMany});
  const auto far_end = static_cast<std::size_t>(far_count);
  spread.describe(fields, "spread", 1, far_end);
  far.describe(fields, "factors", 3, far_end);
  hasRows("spread", spread, knot_end);
  hasRows("factors", far, far_end);
  fields.close();
}

std::size_t Translucency::bytes() const {
  std::size_t sum = knots.size() * 4 + basis.size() * sizeof(float);
  for (const IntegerArray* list : {&texels, &texel_knots, &receivers}) sum += list->data.size();
  for (const EncodedTable* table : {&texel_weights, &areas, &blend, &kernels}) sum += table->data.size();
  for (const SparseRows* matrix : {&sharpen, &near, &spread, &far})
    sum += matrix->ends.data.size() + matrix->columns.data.size() + matrix->values.data.size();
  return sum;
}

}  // namespace bakelight::formats
