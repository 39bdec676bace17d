#include "transport/sum_product.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <stdexcept>

namespace bakelight::transport {
namespace {

using formats::kMostTileEntries;
using formats::RowGroup;
using formats::SumGrammar;
using formats::SumTile;

constexpr std::size_t kRowsAtOnce = 2048;

float scaleOf(int subsamples) {
  return 1.0F / static_cast<float>(subsamples * subsamples);
}

void scaledLight(std::span<const Radiance4> light, float scale, std::vector<Radiance4>& scaled) {
  scaled.resize(light.size());
  for (std::size_t k = 0; k < light.size(); ++k) scaled[k] = light[k] * scale;
}

// Entry (code − 1) · texels + k is code / subsamples² of texel k's light.
void lightByCode(std::span<const Radiance4> light, int subsamples, std::vector<Radiance4>& scaled) {
  const int full = subsamples * subsamples;
  scaled.resize(light.size() * full);
  for (int code = 1; code <= full; ++code)
    for (std::size_t k = 0; k < light.size(); ++k)
      scaled[(code - 1) * light.size() + k] =
          code == full ? light[k]
                       : Radiance4(light[k] * (static_cast<float>(code) / static_cast<float>(full)));
}

// `kTerms` 0: any number.
template <std::uint32_t kTerms>
const std::uint16_t* addRows(const Radiance4* table, const std::uint16_t* term, RowGroup group,
                             Radiance4* out) {
  const std::uint32_t terms = kTerms == 0 ? group.terms : kTerms;
  for (std::uint32_t row = 0; row < group.rows; ++row, term += terms) {
    Radiance4 sum = table[term[0]];
    for (std::uint32_t i = 1; i < terms; ++i) sum += table[term[i]];
    out[row] = sum;
  }
  return term;
}

const std::uint16_t* addRowsOf(const Radiance4* table, const std::uint16_t* term, RowGroup group,
                               Radiance4* out) {
  switch (group.terms) {
    case 1:
      return addRows<1>(table, term, group, out);
    case 2:
      return addRows<2>(table, term, group, out);
    case 3:
      return addRows<3>(table, term, group, out);
    case 4:
      return addRows<4>(table, term, group, out);
    case 5:
      return addRows<5>(table, term, group, out);
    case 6:
      return addRows<6>(table, term, group, out);
    case 7:
      return addRows<7>(table, term, group, out);
    case 8:
      return addRows<8>(table, term, group, out);
    default:
      return addRows<0>(table, term, group, out);
  }
}

class TileProduct {
 public:
  // `light` is lightByCode's if `tabled`; else leaves are multiplied by their codes.
  TileProduct(const SumGrammar& grammar, const Radiance4* light, bool tabled, Radiance4* values)
      : grammar_(grammar), light_(light), tabled_(tabled), values_(values) {}

  void operator()(std::size_t tile) const {
    const SumTile &begin = grammar_.tiles[tile], &end = grammar_.tiles[tile + 1];
    if (begin.leaf == end.leaf) {
      addCodes(begin, end);
      return;
    }
    static thread_local std::vector<Radiance4> table;
    const std::size_t leaves = end.leaf - begin.leaf, sums = end.sum - begin.sum;
    if (table.size() < leaves + sums) table.resize(kMostTileEntries);
    fillTable(begin, leaves, sums, table.data());
    const std::uint16_t* term = grammar_.terms.data() + begin.term;
    Radiance4* out = values_ + begin.row;
    for (std::uint64_t group = begin.group; group < end.group; ++group) {
      term = addRowsOf(table.data(), term, grammar_.groups[group], out);
      out += grammar_.groups[group].rows;
    }
  }

 private:
  void fillTable(const SumTile& begin, std::size_t leaves, std::size_t sums, Radiance4* table) const {
    const std::uint16_t* column = grammar_.leaf_columns.data() + begin.leaf;
    const std::uint8_t* code = grammar_.leaf_codes.data() + begin.leaf;
    for (std::size_t i = 0; i < leaves; ++i) table[i] = leaf(column[i], code[i]);
    const std::uint16_t* part = grammar_.sum_parts.data() + 2 * begin.sum;
    Radiance4* sum = table + leaves;
    for (std::size_t i = 0; i < sums; ++i, part += 2) sum[i] = table[part[0]] + table[part[1]];
  }

  Radiance4 leaf(std::uint16_t column, std::uint8_t code) const {
    if (!tabled_) return light_[column] * static_cast<float>(code);
    return light_[(code - 1) * grammar_.columnCount() + column];
  }

  void addCodes(const SumTile& begin, const SumTile& end) const {
    const std::uint16_t* column = grammar_.terms.data() + begin.term;
    const std::uint8_t* code = grammar_.term_codes.data() + begin.code;
    Radiance4* out = values_ + begin.row;
    for (std::uint64_t group = begin.group; group < end.group; ++group)
      for (std::uint32_t row = 0; row < grammar_.groups[group].rows; ++row) {
        Radiance4 sum = Radiance4::Zero();
        for (std::uint32_t i = 0; i < grammar_.groups[group].terms; ++i) sum += leaf(*column++, *code++);
        *out++ = sum;
      }
  }

  const SumGrammar& grammar_;
  const Radiance4* light_;
  bool tabled_;
  Radiance4* values_;
};

}  // namespace

void multiply(const SumGrammar& grammar, std::span<const Radiance4> light, std::span<Radiance4> values) {
  if (light.size() != grammar.columnCount() || values.size() != grammar.row_places.size())
    throw std::invalid_argument("light and values do not fit the matrix");
  const bool tabled = grammar.subsamples <= kMostTabledSubsamples;
  // Kept, as its pages cost more to get than to fill.
  static thread_local std::vector<Radiance4> scaled;
  tabled ? lightByCode(light, grammar.subsamples, scaled)
         : scaledLight(light, scaleOf(grammar.subsamples), scaled);
  tbb::parallel_for(std::size_t{0}, grammar.tileCount(),
                    TileProduct(grammar, scaled.data(), tabled, values.data()), tbb::simple_partitioner());
}

std::vector<std::uint32_t> valuePlaces(const SumGrammar& grammar) {
  std::vector<std::uint32_t> places(grammar.row_count, kNoValue);
  for (std::size_t value = 0; value < grammar.row_places.size(); ++value)
    places[grammar.row_places[value]] = static_cast<std::uint32_t>(value);
  return places;
}

void multiply(const formats::PixelCodes& codes, std::span<const Radiance4> light,
              std::span<Radiance4> values) {
  if (light.size() != codes.columnCount() || values.size() != codes.rowCount())
    throw std::invalid_argument("light and values do not fit the matrix");
  std::vector<Radiance4> scaled;
  scaledLight(light, scaleOf(codes.subsamples), scaled);
  float factors[256];
  for (int code = 0; code < 256; ++code) factors[code] = static_cast<float>(code);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, codes.rowCount(), kRowsAtOnce),
                    [&](const auto& range) {
                      for (std::size_t row = range.begin(); row < range.end(); ++row) {
                        const std::uint64_t end = codes.row_offsets[row + 1];
                        Radiance4 even = Radiance4::Zero(), odd = Radiance4::Zero();
                        std::uint64_t i = codes.row_offsets[row];
                        for (; i + 1 < end; i += 2) {
                          even += scaled[codes.columns[i]] * factors[codes.codes[i]];
                          odd += scaled[codes.columns[i + 1]] * factors[codes.codes[i + 1]];
                        }
                        if (i < end) even += scaled[codes.columns[i]] * factors[codes.codes[i]];
                        values[row] = even + odd;
                      }
                    });
}

}  // namespace bakelight::transport
