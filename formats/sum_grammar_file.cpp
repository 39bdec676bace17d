#include "formats/sum_grammar_file.h"

#include <draco/compression/entropy/symbol_decoding.h>
#include <draco/compression/entropy/symbol_encoding.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <numeric>

#include "formats/error.h"
#include "formats/hash.h"

namespace bakelight::formats {
namespace {

// What is coded together, as it is alike. Lowest columns are told by their places among the columns that the tile has leaves of,
// steps from one to a higher one as differences of columns, less 1.
enum Stream {
  kRowTiles,  // a row of the matrix: 0 none, 1 and 2 as the row above it in its cells or before it, 3 + its tile
  kRowTerms,      // of rows that have a tile, less 1
  kTileCounts,    // a tile: leaves, levels
  kLeafColumns,   // from leaf to leaf
  kLeafCodes,     // less 1
  kLevelCounts,   // sums of a level
  kSumAnchors,    // lowest column of a sum, from sum to sum
  kSumRanks,      // of its first part among the entries with that lowest column
  kPartSteps,     // from its first part's lowest column to its second's
  kPartRanks,     // of its second part
  kRowAnchors,    // lowest column of a row, from that of the tile's row before it, the sign in the lowest bit
  kTermRanks,     // of each of its terms
  kTermSteps,     // from lowest column to lowest column
  kPlainColumns,  // of a row that is stored as it is: from column to column
  kPlainCodes,    // less 1
  kStreams
};
constexpr std::array<const char*, kStreams> kNames = {
    "row_tiles",    "row_terms",   "tile_counts", "leaf_columns",  "leaf_codes",
    "level_counts", "sum_anchors", "sum_ranks",   "part_steps",    "part_ranks",
    "row_anchors",  "term_ranks",  "term_steps",  "plain_columns", "plain_codes"};

using Streams = std::array<std::vector<std::uint32_t>, kStreams>;

// The entries of a tile by their lowest column, the most used first, as far as uses are known.
class Ranks {
 public:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  void clear() { columns_.clear(), by_column_.clear(), anchors_.clear(), ranks_.clear(), uses_.clear(); }
  void addColumn(std::uint16_t column) { columns_.push_back(column), by_column_.emplace_back(); }
  std::uint32_t columns() const { return static_cast<std::uint32_t>(by_column_.size()); }
  std::uint32_t stepBetween(std::uint32_t anchor, std::uint32_t higher) const {
    return columns_[higher] - columns_[anchor] - 1U;
  }
  // The place of the column that the step leads to; kNone if the tile has no such.
  std::uint64_t afterStep(std::uint64_t anchor, std::uint32_t step) const {
    if (anchor >= columns_.size()) return kNone;
    const std::uint64_t column = std::uint64_t{columns_[anchor]} + step + 1;
    const auto found = std::lower_bound(columns_.begin(), columns_.end(), column);
    return found != columns_.end() && *found == column ? static_cast<std::uint64_t>(found - columns_.begin())
                                                       : kNone;
  }
  void add(std::uint32_t anchor) {
    ranks_.push_back(static_cast<std::uint32_t>(by_column_[anchor].size()));
    by_column_[anchor].push_back(static_cast<std::uint32_t>(anchors_.size()));
    anchors_.push_back(anchor);
    uses_.push_back(0);
  }
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
  std::uint32_t useAt(std::uint64_t anchor, std::uint32_t rank) {
    if (anchor >= by_column_.size() || rank >= by_column_[anchor].size()) return kNone;
    const std::uint32_t entry = by_column_[anchor][rank];
    use(entry);
    return entry;
  }

 private:
  std::vector<std::uint16_t> columns_;
  std::vector<std::vector<std::uint32_t>> by_column_;
  std::vector<std::uint32_t> anchors_, ranks_, uses_;
};

constexpr std::uint32_t kNoTile = ~std::uint32_t{0};

// What is told of a row's tile if those of other rows are known.
class TileGuess {
 public:
  explicit TileGuess(int local_side) : above_(static_cast<std::size_t>(local_side)) {}
  std::uint32_t above(const std::vector<std::uint32_t>& tiles, std::size_t row) const {
    return row >= above_ ? tiles[row - above_] : kNoTile;
  }
  static std::uint32_t before(const std::vector<std::uint32_t>& tiles, std::size_t row) {
    return row >= 1 ? tiles[row - 1] : kNoTile;
  }

 private:
  std::size_t above_;
};

std::uint32_t signLast(std::int64_t value) {
  return static_cast<std::uint32_t>(value < 0 ? -2 * value - 1 : 2 * value);
}
std::int64_t fromSignLast(std::uint32_t value) {
  return value % 2 == 1 ? -static_cast<std::int64_t>(value / 2) - 1 : value / 2;
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
    }
    return std::move(streams_);
  }

 private:
  struct RowTerms {
    std::uint32_t place, terms;
    std::uint64_t term, code;
  };

  void put(Stream stream, std::uint64_t value) {
    streams_[stream].push_back(static_cast<std::uint32_t>(value));
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
        put(kSumAnchors, anchor - last), put(kSumRanks, ranks_.use(parts[0]));
        put(kPartSteps, ranks_.stepBetween(anchor, ranks_.anchor(parts[1]))),
            put(kPartRanks, ranks_.use(parts[1]));
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
        put(kTermRanks, ranks_.use(term));
        last = anchor;
      }
    }
  }

  const SumGrammar& grammar_;
  SumTile begin_, end_;
  Ranks ranks_;
  Streams streams_;
};

class Decoder {
 public:
  Decoder(const Streams& streams, SumGrammar& grammar, const std::string& name)
      : streams_(streams), grammar_(grammar), name_(name), full_(grammar.subsamples * grammar.subsamples) {}

  void decode() {
    rows();
    grammar_.tiles.push_back({});
    for (std::uint32_t tile = 0; tile < tile_rows_.size(); ++tile) {
      const std::uint32_t leaf_count = get(kTileCounts), levels = get(kTileCounts);
      ranks_.clear();
      leaves(leaf_count);
      for (std::uint32_t level = 0; level < levels; ++level) sumsOfLevel(leaf_count);
      tileRows(tile_rows_[tile]);
      grammar_.tiles.push_back({grammar_.leaf_columns.size(), grammar_.sum_parts.size() / 2,
                                grammar_.level_ends.size(), grammar_.groups.size(), grammar_.terms.size(),
                                grammar_.term_codes.size(), grammar_.row_places.size()});
    }
    for (int stream = 0; stream < kStreams; ++stream)
      if (next_[stream] != streams_[stream].size())
        fail(static_cast<Stream>(stream), "values that belong to no tile");
  }

 private:
  struct Row {
    std::uint32_t place, terms;
    std::uint64_t term = 0;    // where its terms are
    std::uint32_t anchor = 0;  // its lowest column; as it is: 0
  };

  [[noreturn]] void fail(Stream stream, const std::string& what) const {
    throw badInput(
        {name_, std::string("tensor ") + kNames[stream] + ", value " + std::to_string(next_[stream]), ""},
        what, "what bicluster wrote", "make the file again");
  }
  std::uint32_t get(Stream stream) {
    if (next_[stream] == streams_[stream].size()) fail(stream, "the values end too early");
    return streams_[stream][next_[stream]++];
  }
  std::uint16_t column(Stream stream, std::uint64_t value) const {
    if (value >= grammar_.columnCount()) fail(stream, "a column beyond the cube map");
    return static_cast<std::uint16_t>(value);
  }
  std::uint8_t code(Stream stream) {
    const std::uint32_t code = get(stream);
    if (code >= static_cast<std::uint32_t>(full_)) fail(stream, "a code beyond subsamples²");
    return static_cast<std::uint8_t>(code + 1);
  }
  std::uint16_t entry(Stream stream, std::uint64_t anchor) {
    const std::uint32_t found = ranks_.useAt(anchor, get(stream));
    if (found == Ranks::kNone) fail(stream, "an entry that is not there");
    return static_cast<std::uint16_t>(found);
  }
  void add(Stream stream, std::uint32_t anchor) {
    if (ranks_.size() == kMostTileEntries) fail(stream, "more than 65536 entries of a tile");
    ranks_.add(anchor);
  }

  void rows() {
    if (streams_[kRowTiles].size() != grammar_.row_count)
      fail(kRowTiles, "another number of rows than the metadata says");
    tile_rows_.resize(streams_[kTileCounts].size() / 2);
    std::vector<std::uint32_t> tiles(grammar_.row_count, kNoTile);
    const TileGuess guess(grammar_.local_side);
    for (std::size_t row = 0; row < tiles.size(); ++row) {
      const std::uint32_t told = get(kRowTiles);
      if (told == 0) continue;
      tiles[row] = told == 1 ? guess.above(tiles, row) : told == 2 ? TileGuess::before(tiles, row) : told - 3;
      if (tiles[row] >= tile_rows_.size()) fail(kRowTiles, "a tile that is not there");
      const std::uint32_t terms = get(kRowTerms);
      if (terms >= grammar_.columnCount()) fail(kRowTerms, "a row of more terms than there are columns");
      tile_rows_[tiles[row]].push_back({static_cast<std::uint32_t>(row), terms + 1});
    }
  }

  void leaves(std::uint32_t count) {
    std::uint64_t last = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t step = get(kLeafColumns);
      last = column(kLeafColumns, last + step);
      grammar_.leaf_columns.push_back(static_cast<std::uint16_t>(last));
      grammar_.leaf_codes.push_back(code(kLeafCodes));
      if (i == 0 || step > 0) ranks_.addColumn(static_cast<std::uint16_t>(last));
      add(kLeafColumns, ranks_.columns() - 1);
    }
  }

  void sumsOfLevel(std::uint32_t leaf_count) {
    const std::uint32_t count = get(kLevelCounts);
    std::uint64_t anchor = 0;
    std::vector<std::uint32_t> anchors;
    for (std::uint32_t i = 0; i < count; ++i) {
      anchor += get(kSumAnchors);
      grammar_.sum_parts.push_back(entry(kSumRanks, anchor));
      const std::uint64_t second = ranks_.afterStep(anchor, get(kPartSteps));
      grammar_.sum_parts.push_back(entry(kPartRanks, second));
      anchors.push_back(static_cast<std::uint32_t>(anchor));
    }
    for (const std::uint32_t a : anchors) add(kSumAnchors, a);
    grammar_.level_ends.push_back(static_cast<std::uint32_t>(ranks_.size() - leaf_count));
  }

  // Rows come by place and lie by the number of their terms, then by lowest column.
  void tileRows(std::vector<Row>& rows) {
    const bool plain = ranks_.size() == 0;
    const Stream stream = plain ? kPlainColumns : kTermRanks;
    std::uint64_t terms = 0;
    for (const Row& row : rows) terms += row.terms;
    if (terms > streams_[stream].size() - next_[stream]) fail(stream, "the values end too early");
    std::vector<std::uint16_t> by_place(terms);
    std::vector<std::uint8_t> codes(plain ? terms : 0);
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
    std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
      return a.terms != b.terms ? a.terms < b.terms : a.anchor < b.anchor;
    });
    std::uint32_t last = 0;
    for (const Row& row : rows) {
      if (row.terms != last) grammar_.groups.push_back({row.terms, 0});
      last = row.terms;
      ++grammar_.groups.back().rows;
      grammar_.row_places.push_back(row.place);
      const std::uint16_t* from = by_place.data() + row.term;
      grammar_.terms.insert(grammar_.terms.end(), from, from + row.terms);
      if (plain)
        grammar_.term_codes.insert(grammar_.term_codes.end(), codes.data() + row.term,
                                   codes.data() + row.term + row.terms);
    }
  }
  void sharingRow(std::uint32_t terms, std::uint64_t anchor, std::uint16_t* out) {
    for (std::uint32_t t = 0; t < terms; ++t) {
      if (t > 0) anchor = ranks_.afterStep(anchor, get(kTermSteps));
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
  const std::string& name_;
  Ranks ranks_;
  int full_;
  std::array<std::size_t, kStreams> next_{};
  std::vector<std::vector<Row>> tile_rows_;
};

// Draco counts in int.
constexpr std::size_t kMostSymbols = std::size_t{1} << 24;

// The count, then blocks of Draco's entropy coder.
Tensor encodedStream(const std::vector<std::uint32_t>& values) {
  draco::EncoderBuffer buffer;
  buffer.Encode(static_cast<std::uint64_t>(values.size()));
  for (std::size_t begin = 0; begin < values.size(); begin += kMostSymbols) {
    const std::size_t count = std::min(kMostSymbols, values.size() - begin);
    if (!draco::EncodeSymbols(values.data() + begin, static_cast<int>(count), 1, nullptr, &buffer))
      throw std::logic_error("symbols that cannot be coded");
  }
  return Tensor::from<char>(ElementType::kUint8, {buffer.size()}, {buffer.data(), buffer.size()});
}

std::vector<std::uint32_t> decodedStream(const Tensor& tensor, std::uint64_t most, const std::string& name,
                                         const char* stream) {
  const auto bytes = tensor.as<char>();
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size(), DRACO_BITSTREAM_VERSION(2, 2));
  std::uint64_t count = 0;
  const auto fail = [&] {
    return badInput({name, std::string("tensor ") + stream, ""}, "its code is broken", "what bicluster wrote",
                    "make the file again");
  };
  if (!buffer.Decode(&count) || count > most) throw fail();
  std::vector<std::uint32_t> values(count);
  for (std::size_t begin = 0; begin < count; begin += kMostSymbols) {
    const auto block = static_cast<std::uint32_t>(std::min<std::size_t>(kMostSymbols, count - begin));
    if (!draco::DecodeSymbols(block, 1, &buffer, values.data() + begin)) throw fail();
  }
  return values;
}

std::uint64_t numberOf(const TensorFile& file, const std::string& key, std::uint64_t least,
                       std::uint64_t most, const std::string& name) {
  const std::string& text = file.requireMetadata(key, name);
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < least || value > most)
    throw badInput({name, "metadata " + key, ""}, "\"" + text + "\" is not a number that it may be",
                   std::to_string(least) + " to " + std::to_string(most), "make the file again");
  return value;
}

// Of all streams one after the other: Draco's decoder is for whole bytes, so broken ones are found before it sees them.
std::string digestOf(const TensorFile& file) {
  std::string digests;
  for (const char* stream : kNames)
    if (const auto found = file.tensors.find(stream); found != file.tensors.end())
      digests += checksumHex(std::span(found->second.data.data(), found->second.data.size()));
  return contentHash(digests);
}

}  // namespace

TensorFile encodeSumGrammar(const SumGrammar& grammar) {
  TensorFile file;
  const Streams streams = Encoder(grammar).encode();
  std::uint64_t symbols = 0;
  for (int stream = 0; stream < kStreams; ++stream) {
    file.tensors[kNames[stream]] = encodedStream(streams[stream]);
    symbols = std::max<std::uint64_t>(symbols, streams[stream].size());
  }
  file.metadata = {{"technique", "sum_grammar"},
                   {"cube_side", std::to_string(grammar.cube_side)},
                   {"local_side", std::to_string(grammar.local_side)},
                   {"subsamples", std::to_string(grammar.subsamples)},
                   {"rows", std::to_string(grammar.row_count)},
                   {"longest_stream", std::to_string(symbols)},
                   {"digest", digestOf(file)}};
  return file;
}

SumGrammar decodeSumGrammar(const TensorFile& file, const std::string& name) {
  SumGrammar grammar;
  grammar.cube_side = static_cast<int>(numberOf(file, "cube_side", 1, 104, name));
  grammar.local_side = static_cast<int>(numberOf(file, "local_side", 1, 32, name));
  grammar.subsamples = static_cast<int>(numberOf(file, "subsamples", 1, 15, name));
  grammar.row_count = numberOf(file, "rows", 0, std::numeric_limits<std::uint32_t>::max() - 1, name);
  const std::uint64_t most = numberOf(file, "longest_stream", 0, std::uint64_t{1} << 40, name);
  if (file.requireMetadata("digest", name) != digestOf(file))
    throw badInput({name, "metadata digest", ""}, "the tensors are not those that were written",
                   "an undamaged file", "make the file again");
  Streams streams;
  for (int stream = 0; stream < kStreams; ++stream)
    streams[stream] =
        decodedStream(file.require(kNames[stream], ElementType::kUint8, 1, name), most, name, kNames[stream]);
  Decoder(streams, grammar, name).decode();
  return grammar;
}

std::uint64_t encodedBytes(const TensorFile& file) {
  std::uint64_t bytes = 0;
  for (const char* stream : kNames) bytes += file.tensors.at(stream).data.size();
  return bytes;
}

}  // namespace bakelight::formats
