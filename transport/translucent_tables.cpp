#include "transport/translucent_tables.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace bakelight::transport {
namespace {

using formats::wordsOf;

constexpr std::size_t kValues = std::size_t{3} * formats::kKernelTexels;

// Where each of `count` bins begins, and at the end how much there is; `binsOf` calls a function with the bin of each element.
template <class BinsOf>
std::vector<std::uint32_t> beginsOf(std::size_t count, const BinsOf& binsOf) {
  std::vector<std::uint32_t> begins(count + 1, 0);
  binsOf([&](std::size_t bin) { ++begins[bin + 1]; });
  std::partial_sum(begins.begin(), begins.end(), begins.begin());
  return begins;
}

bool fits(const formats::EncodedTable& table, std::size_t rows, std::size_t columns) {
  return table.rows == rows && (rows == 0 || table.columns == columns);
}

bool fits(const formats::SparseRows& matrix, std::size_t rows, std::size_t columns,
          std::size_t value_columns) {
  const auto ends = matrix.endsOf(), places = matrix.columnsOf();
  return matrix.rows() == rows && fits(matrix.values, places.size(), value_columns) &&
         std::is_sorted(ends.begin(), ends.end()) && (ends.empty() ? 0 : ends.back()) == places.size() &&
         std::all_of(places.begin(), places.end(), [&](std::uint32_t c) { return c < columns; });
}

bool areBelow(const formats::IntegerArray& values, std::size_t end) {
  const auto words = wordsOf(values);
  return std::all_of(words.begin(), words.end(), [&](std::uint32_t v) { return v < end; });
}

}  // namespace

void requireFit(const formats::Translucency& t) {
  const std::size_t texels = t.texelCount(), receivers = t.receiverCount();
  const auto knots = static_cast<std::size_t>(t.knot_count), far = static_cast<std::size_t>(t.far_count);
  const auto components = static_cast<std::size_t>(t.components);
  const bool kernels_fit = fits(t.kernels, receivers, components > 0 ? components : kValues) &&
                           t.basis.size() == components * kValues;
  const bool texels_fit = fits(t.texel_weights, texels, 2) && fits(t.blend, texels, 9) &&
                          fits(t.areas, texels, 1) && t.texel_knots.count() == 3 * texels;
  const bool places_fit =
      areBelow(t.texels, static_cast<std::size_t>(t.resolution) * static_cast<std::size_t>(t.resolution)) &&
      areBelow(t.texel_knots, knots) && areBelow(t.receivers, texels);
  const bool matrices_fit = fits(t.sharpen, knots, knots, 1) && fits(t.near, knots, knots, 3) &&
                            (far == 0 || (fits(t.spread, knots, far, 1) && fits(t.far, far, far, 3)));
  if (!kernels_fit || !texels_fit || !places_fit || !matrices_fit)
    throw std::invalid_argument("a translucent object's tables do not fit each other");
}

formats::SparseRows transposed(const formats::SparseRows& rows, std::size_t columns) {
  const auto ends = rows.endsOf(), places = rows.columnsOf();
  std::vector<std::uint32_t> next = beginsOf(columns, [&](const auto& add) {
    for (const std::uint32_t c : places) add(c);
  });
  const std::vector<std::uint32_t> new_ends(next.begin() + 1, next.end());
  std::vector<std::uint32_t> new_columns(places.size());
  const std::size_t entry_bytes = rows.values.rowBytes();
  formats::Bytes bytes(places.size() * entry_bytes);
  for (std::size_t r = 0, e = 0; r < ends.size(); ++r)
    for (; e < ends[r]; ++e) {
      const std::uint32_t place = next[places[e]]++;
      new_columns[place] = static_cast<std::uint32_t>(r);
      std::memcpy(&bytes[place * entry_bytes], rows.values.data.data() + e * entry_bytes, entry_bytes);
    }
  formats::SparseRows result{formats::integersOf(new_ends), formats::integersOf(new_columns), rows.values};
  result.values.data = std::move(bytes);
  return result;
}

std::vector<formats::Float3> knotWeights(const formats::Translucency& t) {
  const std::vector<float> weights = t.texel_weights.decode();
  std::vector<formats::Float3> result(t.texelCount());
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = {1 - weights[2 * i] - weights[2 * i + 1], weights[2 * i], weights[2 * i + 1]};
  return result;
}

Gifts giftsOf(const formats::Translucency& t) {
  const std::vector<float> areas = t.areas.decode(), blend = t.blend.decode();
  const std::vector<formats::Float3> weights = knotWeights(t);
  const auto knots = wordsOf(t.texel_knots);
  const auto forEach = [&](const auto& give) {
    for (std::size_t i = 0; i < areas.size(); ++i)
      if (areas[i] > 0)
        for (std::size_t k = 0; k < 3; ++k) give(i, k);
  };
  std::vector<std::uint32_t> next = beginsOf(static_cast<std::size_t>(t.knot_count), [&](const auto& add) {
    forEach([&](std::size_t i, std::size_t k) { add(knots[3 * i + k]); });
  });
  Gifts result{{next.begin() + 1, next.end()}, std::vector<Gift>(next.back())};
  forEach([&](std::size_t i, std::size_t k) {
    const float* b = &blend[9 * i + 3 * k];
    result.gifts[next[knots[3 * i + k]]++] = {
        static_cast<std::uint32_t>(i), weights[i][k] * areas[i], {b[0], b[1], b[2]}};
  });
  return result;
}

std::vector<float> expandedKernels(const formats::Translucency& t) {
  std::vector<float> kernels = t.kernels.decode();
  if (t.components == 0) return kernels;
  const auto components = static_cast<std::size_t>(t.components);
  std::vector<float> expanded(t.receiverCount() * kValues, 0);
  tbb::parallel_for(std::size_t{0}, t.receiverCount(), [&](std::size_t r) {
    for (std::size_t c = 0; c < components; ++c)
      for (std::size_t v = 0; v < kValues; ++v)
        expanded[r * kValues + v] += kernels[r * components + c] * t.basis[c * kValues + v];
  });
  return expanded;
}

std::vector<formats::Float3> stainOf(const formats::Pack& pack) {
  std::vector<formats::Float3> stain = pack.colors;
  stain.resize(pack.mesh.vertexCount(), {1, 1, 1});
  for (formats::Float3& color : stain)
    for (std::size_t c = 0; c < 3; ++c) color[c] *= pack.appearances.front().base_color[c];
  return stain;
}

}  // namespace bakelight::transport
