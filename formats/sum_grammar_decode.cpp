#include <draco/compression/entropy/symbol_decoding.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <functional>
#include <span>
#include <system_error>
#include <thread>
#include <vector>

#include "formats/error.h"
#include "formats/sum_grammar_code.h"
#include "formats/sum_streams.h"

namespace bakelight::formats {
namespace {

struct Streams {
  std::array<std::vector<std::uint32_t>, kSumStreams> values;
  ByRank<std::vector<std::uint32_t>> ranks;
};
// Where a tile's values begin.
struct Cursors {
  std::array<std::size_t, kSumStreams> values{};
  ByRank<std::size_t> ranks{};
};

[[noreturn]] void fail(const std::string& file, SumStream stream, std::size_t value,
                       const std::string& what) {
  throw badInput(
      {file, std::string("tensor ") + kSumStreamNames[stream] + ", value " + std::to_string(value), ""}, what,
      "what bicluster wrote", "make the file again");
}

std::int64_t fromSignLast(std::uint32_t value) {
  return value % 2 == 1 ? -static_cast<std::int64_t>(value / 2) - 1 : value / 2;
}

// All of them, and the first error there is in order, whoever finds one first. With the standard library's threads: who links the
// reader of packs alone needs no other library.
void forAll(std::size_t count, const std::function<void(std::size_t)>& work) {
  std::vector<std::exception_ptr> errors(count);
  std::atomic<std::size_t> next = 0;
  const auto serve = [&] {
    for (std::size_t i = next++; i < count; i = next++) try {
        work(i);
      } catch (...) {
        errors[i] = std::current_exception();
      }
  };
  {
    std::vector<std::jthread> others;
    const std::size_t workers = std::min<std::size_t>(count, std::thread::hardware_concurrency());
    try {
      while (others.size() + 1 < workers) others.emplace_back(serve);
    } catch (const std::system_error&) {
      // As many as there could be.
    }
    serve();
  }
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
}

// The entries of a tile by their lowest column, the most used first, as far as uses are known.
class RankedEntries {
 public:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  explicit RankedEntries(std::size_t columns) : place_of_column_(columns, kNoPlace) {}

  void addColumn(std::uint16_t column) {
    place_of_column_[column] = static_cast<std::uint16_t>(columns_.size());
    columns_.push_back(column), ranked_.emplace_back();
  }
  std::uint32_t columns() const { return static_cast<std::uint32_t>(ranked_.size()); }
  void add(std::uint32_t anchor) {
    ranked_[anchor].entries.push_back(static_cast<std::uint16_t>(size_++));
    ranked_[anchor].uses.push_back(0);
  }
  std::size_t size() const { return size_; }

  std::size_t entriesAt(std::uint64_t anchor) const {
    return anchor < ranked_.size() ? ranked_[anchor].entries.size() : 0;
  }

  // The place of the column that the step leads to; kNone if the tile has no such.
  std::uint64_t afterStep(std::uint64_t anchor, std::uint32_t step) const {
    if (anchor >= columns_.size()) return kNone;
    const std::uint64_t column = std::uint64_t{columns_[anchor]} + step + 1;
    if (column >= place_of_column_.size() || place_of_column_[column] == kNoPlace) return kNone;
    return place_of_column_[column];
  }

  // The entry at the rank, which is then used once more; kNone if there is none.
  std::uint32_t useAt(std::uint64_t anchor, std::uint32_t rank) {
    if (anchor >= ranked_.size() || rank >= ranked_[anchor].entries.size()) return kNone;
    auto& [entries, uses] = ranked_[anchor];
    const std::uint16_t entry = entries[rank];
    // It goes before all that were used as often as it.
    const std::uint32_t used = uses[rank]++;
    const auto end = uses.begin() + rank;
    const auto to = std::partition_point(uses.begin(), end, [&](std::uint32_t u) { return u > used; });
    if (to == end) return entry;
    const auto first = entries.begin() + (to - uses.begin());
    std::copy_backward(first, entries.begin() + rank, entries.begin() + rank + 1);
    *first = entry;
    *to = used + 1, *end = used;
    return entry;
  }

 private:
  struct Ranked {
    std::vector<std::uint16_t> entries;
    std::vector<std::uint32_t> uses;  // descending
  };
  static constexpr std::uint16_t kNoPlace = 0xffff;  // there are fewer columns

  std::vector<std::uint16_t> columns_, place_of_column_;
  std::vector<Ranked> ranked_;
  std::size_t size_ = 0;
};

struct Row {
  std::uint32_t place, terms;
  std::uint64_t term = 0;    // where its terms are
  std::uint32_t anchor = 0;  // its lowest column; as it is: 0
};

// A tile, from the values that stand at its cursors in the streams to its part of the grammar's arrays.
class TileDecoder {
 public:
  TileDecoder(const Streams& streams, SumGrammar& grammar, const std::string& file, std::size_t tile,
              const std::vector<Cursors>& cursors)
      : streams_(streams),
        grammar_(grammar),
        file_(file),
        begin_(grammar.tiles[tile]),
        end_(grammar.tiles[tile + 1]),
        next_(cursors[tile]),
        rank_ends_(cursors[tile + 1].ranks),
        entries_(grammar.columnCount()),
        full_(static_cast<std::uint32_t>(grammar.subsamples * grammar.subsamples)) {}

  void decode(std::vector<Row>& rows) {
    leaves();
    std::uint32_t first = 0;
    for (std::uint64_t level = begin_.level; level < end_.level; ++level) {
      sums(first, grammar_.level_ends[level]);
      first = grammar_.level_ends[level];
    }
    tileRows(rows);
    if (next_.ranks != rank_ends_) fail(kRankCounts, "fewer ranks of a tile than it says");
  }

 private:
  [[noreturn]] void fail(SumStream stream, const std::string& what) const {
    formats::fail(file_, stream, next_.values[stream] - 1, what);
  }
  std::uint32_t get(SumStream stream) { return streams_.values[stream][next_.values[stream]++]; }
  std::uint16_t column(SumStream stream, std::uint64_t value) const {
    if (value >= grammar_.columnCount()) fail(stream, "a column beyond the cube map");
    return static_cast<std::uint16_t>(value);
  }
  std::uint8_t code(SumStream stream) {
    const std::uint32_t code = get(stream);
    if (code >= full_) fail(stream, "a code beyond subsamples²");
    return static_cast<std::uint8_t>(code + 1);
  }
  std::uint16_t entry(SumStream stream, std::uint64_t anchor) {
    const std::size_t entries = entries_.entriesAt(anchor);
    const std::uint32_t found = entries_.useAt(anchor, entries > 1 ? rank(stream, entries) : 0);
    if (found == RankedEntries::kNone) fail(stream, "an entry that is not there");
    return static_cast<std::uint16_t>(found);
  }

  std::uint32_t rank(SumStream stream, std::size_t entries) {
    const std::size_t index = rankIndexOf(stream), context = rankContextOf(entries);
    std::size_t& next = next_.ranks[index][context];
    if (next == rank_ends_[index][context]) fail(stream, "more ranks than rank_counts says");
    return streams_.ranks[index][context][next++];
  }

  void leaves() {
    std::uint64_t last = 0;
    for (std::uint64_t i = begin_.leaf; i < end_.leaf; ++i) {
      const std::uint32_t step = get(kLeafColumns);
      last = column(kLeafColumns, last + step);
      grammar_.leaf_columns[i] = static_cast<std::uint16_t>(last);
      grammar_.leaf_codes[i] = code(kLeafCodes);
      if (i == begin_.leaf || step > 0) entries_.addColumn(static_cast<std::uint16_t>(last));
      entries_.add(entries_.columns() - 1);
    }
  }

  // Of a level, whose sums become entries when all are known.
  void sums(std::uint32_t first, std::uint32_t end) {
    std::uint64_t anchor = 0;
    anchors_.clear();
    for (std::uint32_t i = first; i < end; ++i) {
      anchor += get(kSumAnchors);
      std::uint16_t* parts = &grammar_.sum_parts[2 * (begin_.sum + i)];
      parts[0] = entry(kSumRanks, anchor);
      const std::uint64_t second = entries_.afterStep(anchor, get(kPartSteps));
      parts[1] = entry(kPartRanks, second);
      anchors_.push_back(static_cast<std::uint32_t>(anchor));
    }
    for (const std::uint32_t a : anchors_) entries_.add(a);
  }

  // Rows come by place and lie by the number of their terms, then by lowest column.
  void tileRows(std::vector<Row>& rows) {
    const bool plain = begin_.leaf == end_.leaf;
    std::vector<std::uint16_t> by_place(end_.term - begin_.term);
    std::vector<std::uint8_t> codes(end_.code - begin_.code);
    std::uint64_t term = 0;
    std::int64_t anchor = 0;
    for (Row& row : rows) {
      row.term = term;
      if (plain) {
        plainRow(row.terms, by_place.data() + term, codes.data() + term);
      } else {
        anchor += fromSignLast(get(kRowAnchors));
        sharingRow(row.terms, static_cast<std::uint64_t>(anchor), by_place.data() + term);
        row.anchor = static_cast<std::uint32_t>(anchor);
      }
      term += row.terms;
    }
    std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
      if (a.terms != b.terms) return a.terms < b.terms;
      return a.anchor != b.anchor ? a.anchor < b.anchor : a.place < b.place;
    });
    std::uint16_t* terms = grammar_.terms.data() + begin_.term;
    std::uint8_t* term_codes = grammar_.term_codes.data() + begin_.code;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const Row& row = rows[i];
      grammar_.row_places[begin_.row + i] = row.place;
      terms = std::copy_n(by_place.data() + row.term, row.terms, terms);
      if (plain) term_codes = std::copy_n(codes.data() + row.term, row.terms, term_codes);
    }
  }
  void sharingRow(std::uint32_t terms, std::uint64_t anchor, std::uint16_t* out) {
    for (std::uint32_t t = 0; t < terms; ++t) {
      if (t > 0) anchor = entries_.afterStep(anchor, get(kTermSteps));
      out[t] = entry(kTermRanks, anchor);
    }
  }
  void plainRow(std::uint32_t terms, std::uint16_t* out, std::uint8_t* codes) {
    std::uint64_t next = 0;
    for (std::uint32_t t = 0; t < terms; ++t) {
      out[t] = column(kPlainColumns, next + get(kPlainColumns));
      codes[t] = code(kPlainCodes);
      next = std::uint64_t{out[t]} + 1;
    }
  }

  const Streams& streams_;
  SumGrammar& grammar_;
  const std::string& file_;
  SumTile begin_, end_;
  Cursors next_;
  ByRank<std::size_t> rank_ends_;
  RankedEntries entries_;
  std::uint32_t full_;
  std::vector<std::uint32_t> anchors_;
};

// Counts tell how long each stream is and where each tile's part of it begins, so tiles are decoded at once.
class Decoder {
 public:
  Decoder(const CodedSums& coded, const std::string& file) : coded_(coded), file_(file) {
    grammar_.cube_side = coded.cube_side, grammar_.local_side = coded.local_side;
    grammar_.subsamples = coded.subsamples, grammar_.row_count = coded.row_count;
  }

  SumGrammar decode() {
    rows();
    counts();
    std::vector<SumStream> rest;
    for (int stream = kLeafColumns; stream < kSumStreams; ++stream)
      if (stream != kLevelCounts) rest.push_back(static_cast<SumStream>(stream));
    forAll(rest.size(), [&](std::size_t i) {
      if (std::find(kRankStreams.begin(), kRankStreams.end(), rest[i]) != kRankStreams.end())
        readRanks(rest[i]);
      else
        read(rest[i], cursors_.back().values[rest[i]]);
    });
    const SumTile& end = grammar_.tiles.back();
    grammar_.leaf_columns.resize(end.leaf), grammar_.leaf_codes.resize(end.leaf);
    grammar_.sum_parts.resize(2 * end.sum);
    grammar_.terms.resize(end.term), grammar_.term_codes.resize(end.code);
    grammar_.row_places.resize(end.row);
    forAll(tile_rows_.size(), [&](std::size_t tile) {
      TileDecoder(streams_, grammar_, file_, tile, cursors_).decode(tile_rows_[tile]);
    });
    return std::move(grammar_);
  }

 private:
  std::uint64_t symbolsOf(SumStream stream) const {
    std::uint64_t count = 0;
    if (coded_.streams[stream].size() < sizeof(count)) failCode(stream);
    std::copy_n(coded_.streams[stream].begin(), sizeof(count), reinterpret_cast<std::byte*>(&count));
    return count;
  }
  [[noreturn]] void failCode(SumStream stream) const {
    throw badInput({file_, std::string("tensor ") + kSumStreamNames[stream], ""}, "its code is broken",
                   "what bicluster wrote", "make the file again");
  }
  void read(SumStream stream, std::uint64_t expected) {
    draco::DecoderBuffer buffer = bufferOf(stream);
    readList(stream, expected, buffer, streams_.values[stream]);
  }
  void readRanks(SumStream stream) {
    draco::DecoderBuffer buffer = bufferOf(stream);
    const std::size_t index = rankIndexOf(stream);
    for (std::size_t context = 0; context < kRankContexts; ++context)
      readList(stream, cursors_.back().ranks[index][context], buffer, streams_.ranks[index][context]);
  }
  draco::DecoderBuffer bufferOf(SumStream stream) const {
    draco::DecoderBuffer buffer;
    const SharedBytes& bytes = coded_.streams[stream];
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size(), DRACO_BITSTREAM_VERSION(2, 2));
    return buffer;
  }
  void readList(SumStream stream, std::uint64_t expected, draco::DecoderBuffer& buffer,
                std::vector<std::uint32_t>& values) const {
    std::uint64_t count = 0;
    if (!buffer.Decode(&count)) failCode(stream);
    if (count != expected)
      fail(file_, stream, 0,
           "there are " + std::to_string(count) + " values, not " + std::to_string(expected) +
               " as the counts before them say");
    values.resize(expected);
    for (std::size_t begin = 0; begin < expected; begin += kMostSymbols) {
      const auto block = static_cast<std::uint32_t>(std::min<std::size_t>(kMostSymbols, expected - begin));
      if (!draco::DecodeSymbols(block, 1, &buffer, values.data() + begin)) failCode(stream);
    }
  }

  // Which rows a tile has, and of how many terms each is.
  void rows() {
    read(kRowTiles, coded_.row_count);
    const auto& told = streams_.values[kRowTiles];
    read(kRowTerms, static_cast<std::uint64_t>(std::count_if(told.begin(), told.end(),
                                                             [](std::uint32_t tile) { return tile != 0; })));
    const std::uint64_t tiles = symbolsOf(kTileCounts) / 2;
    if (tiles > streams_.values[kRowTerms].size()) fail(file_, kTileCounts, 0, "more tiles than rows");
    read(kTileCounts, 2 * tiles);
    tile_rows_.resize(tiles);
    std::vector<std::uint32_t> tile_of(told.size(), kNoTile);
    const TileGuess guess(coded_.local_side);
    std::size_t next = 0;
    for (std::size_t row = 0; row < told.size(); ++row) {
      if (told[row] == 0) continue;
      tile_of[row] = told[row] == 1   ? guess.above(tile_of, row)
                     : told[row] == 2 ? TileGuess::before(tile_of, row)
                                      : told[row] - 3;
      if (tile_of[row] >= tiles) fail(file_, kRowTiles, row, "a tile that is not there");
      const std::uint32_t terms = streams_.values[kRowTerms][next++];
      if (terms >= grammar_.columnCount())
        fail(file_, kRowTerms, next - 1, "a row of more terms than there are columns");
      tile_rows_[tile_of[row]].push_back({static_cast<std::uint32_t>(row), terms + 1});
    }
  }

  void counts() {
    std::uint64_t levels = 0;
    for (std::size_t i = 1; i < streams_.values[kTileCounts].size(); i += 2)
      levels += streams_.values[kTileCounts][i];
    read(kLevelCounts, levels);
    read(kRankCounts, tile_rows_.size() * kRankStreams.size() * kRankContexts);
    SumTile end;
    Cursors next;
    auto& cursors = next.values;
    std::vector<std::uint32_t> lengths;
    grammar_.tiles.push_back(end), cursors_.push_back(next);
    for (std::size_t tile = 0; tile < tile_rows_.size(); ++tile) {
      const std::uint64_t leaves = streams_.values[kTileCounts][2 * tile];
      const std::uint32_t tile_levels = streams_.values[kTileCounts][2 * tile + 1];
      std::uint64_t sums = 0;
      for (std::uint32_t level = 0; level < tile_levels; ++level) {
        sums += streams_.values[kLevelCounts][end.level++];
        if (leaves == 0 || leaves + sums > kMostTileEntries)
          fail(file_, kLevelCounts, end.level - 1,
               "sums of a tile without leaves, or more than 65536 entries");
        grammar_.level_ends.push_back(static_cast<std::uint32_t>(sums));
      }
      if (leaves > kMostTileEntries) fail(file_, kTileCounts, 2 * tile, "more than 65536 entries of a tile");
      const std::uint64_t terms = groupRows(tile_rows_[tile], lengths);
      const std::uint64_t rows = tile_rows_[tile].size(), plain_terms = leaves == 0 ? terms : 0;
      end.leaf += leaves, end.sum += sums, end.group = grammar_.groups.size();
      end.term += terms, end.code += plain_terms, end.row += rows;
      grammar_.tiles.push_back(end);
      cursors[kPlainColumns] = cursors[kPlainCodes] = end.code;
      if (leaves > 0) cursors[kRowAnchors] += rows, cursors[kTermSteps] += terms - rows;
      cursors[kLeafColumns] = cursors[kLeafCodes] = end.leaf;
      cursors[kSumAnchors] = cursors[kPartSteps] = end.sum;
      countRanks(tile, {sums, sums, terms - plain_terms}, next.ranks);
      cursors_.push_back(next);
    }
  }

  void countRanks(std::size_t tile, const std::array<std::uint64_t, kRankStreams.size()>& most,
                  ByRank<std::size_t>& ends) const {
    const std::size_t first = tile * kRankStreams.size() * kRankContexts;
    const std::uint32_t* count = &streams_.values[kRankCounts][first];
    for (std::size_t stream = 0; stream < kRankStreams.size(); ++stream) {
      std::uint64_t sum = 0;
      for (std::size_t& end : ends[stream]) sum += *count, end += *count++;
      if (sum > most[stream]) fail(file_, kRankCounts, first, "more ranks than there are sums or terms");
    }
  }

  // How many terms the rows have.
  std::uint64_t groupRows(const std::vector<Row>& rows, std::vector<std::uint32_t>& lengths) {
    lengths.clear();
    for (const Row& row : rows) lengths.push_back(row.terms);
    std::sort(lengths.begin(), lengths.end());
    std::uint64_t terms = 0;
    std::uint32_t last = 0;
    for (const std::uint32_t length : lengths) {
      if (length != last) grammar_.groups.push_back({length, 0});
      last = length, terms += length;
      ++grammar_.groups.back().rows;
    }
    return terms;
  }

  const CodedSums& coded_;
  const std::string& file_;
  SumGrammar grammar_;
  Streams streams_;
  std::vector<std::vector<Row>> tile_rows_;
  std::vector<Cursors> cursors_;  // of a tile, and where the last ends
};

}  // namespace

SumGrammar decodeSums(const CodedSums& coded, const std::string& file) {
  return Decoder(coded, file).decode();
}

}  // namespace bakelight::formats
