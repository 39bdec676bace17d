#include <draco/compression/entropy/symbol_encoding.h>

#include <algorithm>
#include <span>
#include <stdexcept>
#include <utility>

#include "formats/sum_grammar_code.h"
#include "formats/sum_streams.h"

namespace bakelight::formats {
namespace {

struct Streams {
  std::array<std::vector<std::uint32_t>, kSumStreams> values;
  ByRank<std::vector<std::uint32_t>> ranks;
};

// The entries of a tile by their lowest column, the most used first, as far as uses are known.
class Ranks {
 public:
  void clear() { columns_.clear(), by_column_.clear(), anchors_.clear(), ranks_.clear(), uses_.clear(); }
  void addColumn(std::uint16_t column) { columns_.push_back(column), by_column_.emplace_back(); }
  std::uint32_t columns() const { return static_cast<std::uint32_t>(by_column_.size()); }
  std::uint32_t stepBetween(std::uint32_t anchor, std::uint32_t higher) const {
    return columns_[higher] - columns_[anchor] - 1U;
  }
  void add(std::uint32_t anchor) {
    ranks_.push_back(static_cast<std::uint32_t>(by_column_[anchor].size()));
    by_column_[anchor].push_back(static_cast<std::uint32_t>(anchors_.size()));
    anchors_.push_back(anchor);
    uses_.push_back(0);
  }
  std::size_t entriesAt(std::uint32_t anchor) const { return by_column_[anchor].size(); }
  std::uint32_t anchor(std::uint32_t entry) const { return anchors_[entry]; }
  std::size_t size() const { return anchors_.size(); }

  // The rank at which it is found now.
  std::uint32_t use(std::uint32_t entry) {
    auto& column = by_column_[anchors_[entry]];
    const std::uint32_t before = ranks_[entry];
    std::uint32_t rank = before;
    ++uses_[entry];
    for (; rank > 0 && uses_[column[rank - 1]] < uses_[entry]; --rank)
      ranks_[column[rank] = column[rank - 1]] = rank;
    ranks_[column[rank] = entry] = rank;
    return before;
  }

 private:
  std::vector<std::uint16_t> columns_;
  std::vector<std::vector<std::uint32_t>> by_column_;
  std::vector<std::uint32_t> anchors_, ranks_, uses_;
};

std::uint32_t signLast(std::int64_t value) {
  return static_cast<std::uint32_t>(value < 0 ? -2 * value - 1 : 2 * value);
}

class Encoder {
 public:
  explicit Encoder(const SumGrammar& grammar) : grammar_(grammar) {}

  Streams encode() {
    rows();
    for (std::size_t tile = 0; tile < grammar_.tileCount(); ++tile) {
      begin_ = grammar_.tiles[tile], end_ = grammar_.tiles[tile + 1];
      put(kTileCounts, end_.leaf - begin_.leaf), put(kTileCounts, end_.level - begin_.level);
      ranks_.clear();
      leaves();
      sums();
      tileRows();
      for (std::size_t stream = 0; stream < kRankStreams.size(); ++stream)
        for (std::size_t context = 0; context < kRankContexts; ++context)
          put(kRankCounts,
              streams_.ranks[stream][context].size() -
                  std::exchange(before_[stream][context], streams_.ranks[stream][context].size()));
    }
    return std::move(streams_);
  }

 private:
  struct RowTerms {
    std::uint32_t place, terms;
    std::uint64_t term, code;
  };

  void put(SumStream stream, std::uint64_t value) {
    streams_.values[stream].push_back(static_cast<std::uint32_t>(value));
  }

  void putRank(SumStream stream, std::uint32_t entry) {
    const std::size_t entries = ranks_.entriesAt(ranks_.anchor(entry));
    const std::uint32_t rank = ranks_.use(entry);
    if (entries > 1) streams_.ranks[rankIndexOf(stream)][rankContextOf(entries)].push_back(rank);
  }

  // Rows of the tile by their place in the matrix.
  std::vector<RowTerms> rowsOfTile(const SumTile& begin, const SumTile& end) const {
    std::vector<RowTerms> rows;
    std::uint64_t term = begin.term, code = begin.code, row = begin.row;
    for (std::uint64_t g = begin.group; g < end.group; ++g)
      for (std::uint32_t i = 0; i < grammar_.groups[g].rows; ++i, ++row) {
        rows.push_back({grammar_.row_places[row], grammar_.groups[g].terms, term, code});
        term += grammar_.groups[g].terms, code += grammar_.groups[g].terms;
      }
    std::sort(rows.begin(), rows.end(),
              [](const RowTerms& a, const RowTerms& b) { return a.place < b.place; });
    return rows;
  }

  void rows() {
    std::vector<std::uint32_t> tiles(grammar_.row_count, kNoTile), terms(grammar_.row_count, 0);
    for (std::size_t tile = 0; tile < grammar_.tileCount(); ++tile)
      for (const RowTerms& row : rowsOfTile(grammar_.tiles[tile], grammar_.tiles[tile + 1]))
        tiles[row.place] = static_cast<std::uint32_t>(tile), terms[row.place] = row.terms;
    const TileGuess guess(grammar_.local_side);
    for (std::size_t row = 0; row < tiles.size(); ++row) {
      if (tiles[row] == kNoTile) {
        put(kRowTiles, 0);
        continue;
      }
      put(kRowTiles, tiles[row] == guess.above(tiles, row)    ? 1
                     : tiles[row] == guess.before(tiles, row) ? 2
                                                              : 3 + tiles[row]);
      put(kRowTerms, terms[row] - 1);
    }
  }

  void leaves() {
    std::uint16_t last = 0;
    for (std::uint64_t i = begin_.leaf; i < end_.leaf; ++i) {
      const std::uint16_t column = grammar_.leaf_columns[i];
      put(kLeafColumns, column - last), put(kLeafCodes, grammar_.leaf_codes[i] - 1U);
      if (i == begin_.leaf || column != last) ranks_.addColumn(column);
      last = column;
      ranks_.add(ranks_.columns() - 1);
    }
  }

  void sums() {
    std::uint32_t first = 0;
    for (std::uint64_t level = begin_.level; level < end_.level; ++level) {
      const std::uint32_t end = grammar_.level_ends[level];
      put(kLevelCounts, end - first);
      std::uint32_t last = 0;
      std::vector<std::uint32_t> anchors;
      for (; first < end; ++first) {
        const std::uint16_t* parts = &grammar_.sum_parts[2 * (begin_.sum + first)];
        const std::uint32_t anchor = ranks_.anchor(parts[0]);
        put(kSumAnchors, anchor - last), putRank(kSumRanks, parts[0]);
        put(kPartSteps, ranks_.stepBetween(anchor, ranks_.anchor(parts[1]))), putRank(kPartRanks, parts[1]);
        anchors.push_back(anchor);
        last = anchor;
      }
      for (const std::uint32_t anchor : anchors) ranks_.add(anchor);
    }
  }

  void tileRows() {
    std::uint32_t last_row = 0;
    for (const RowTerms& row : rowsOfTile(begin_, end_)) {
      std::uint32_t last = 0;
      for (std::uint32_t t = 0; t < row.terms; ++t) {
        const std::uint16_t term = grammar_.terms[row.term + t];
        if (ranks_.size() == 0) {
          put(kPlainColumns, term - (t == 0 ? 0 : last + 1)),
              put(kPlainCodes, grammar_.term_codes[row.code + t] - 1U);
          last = term;
          continue;
        }
        const std::uint32_t anchor = ranks_.anchor(term);
        t == 0 ? put(kRowAnchors, signLast(static_cast<std::int64_t>(anchor) - last_row))
               : put(kTermSteps, ranks_.stepBetween(last, anchor));
        if (t == 0) last_row = anchor;
        putRank(kTermRanks, term);
        last = anchor;
      }
    }
  }

  const SumGrammar& grammar_;
  SumTile begin_, end_;
  Ranks ranks_;
  Streams streams_;
  ByRank<std::size_t> before_{};  // ranks of tiles before this one
};

// The count, then blocks of Draco's entropy coder.
void encode(const std::vector<std::uint32_t>& values, draco::EncoderBuffer& buffer) {
  buffer.Encode(static_cast<std::uint64_t>(values.size()));
  for (std::size_t begin = 0; begin < values.size(); begin += kMostSymbols) {
    const std::size_t count = std::min(kMostSymbols, values.size() - begin);
    if (!draco::EncodeSymbols(values.data() + begin, static_cast<int>(count), 1, nullptr, &buffer))
      throw std::logic_error("symbols that cannot be coded");
  }
}

Bytes bytesOf(const draco::EncoderBuffer& buffer) {
  const auto bytes = std::as_bytes(std::span(buffer.data(), buffer.size()));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

CodedSums encodeSums(const SumGrammar& grammar) {
  CodedSums coded{grammar.cube_side, grammar.local_side, grammar.subsamples, grammar.row_count, {}};
  const Streams streams = Encoder(grammar).encode();
  for (int stream = 0; stream < kSumStreams; ++stream) {
    draco::EncoderBuffer buffer;
    if (std::find(kRankStreams.begin(), kRankStreams.end(), stream) == kRankStreams.end())
      encode(streams.values[stream], buffer);
    else
      for (const auto& ranks : streams.ranks[rankIndexOf(static_cast<SumStream>(stream))])
        encode(ranks, buffer);
    coded.streams[stream] = bytesOf(buffer);
  }
  return coded;
}

}  // namespace bakelight::formats
