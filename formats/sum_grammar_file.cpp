#include "formats/sum_grammar_file.h"

#include <draco/compression/entropy/symbol_decoding.h>
#include <draco/compression/entropy/symbol_encoding.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>

#include "formats/error.h"
#include "formats/hash.h"

namespace bakelight::formats {
namespace {

// What is coded together, as it is alike. Steps are differences that are at least 1, less 1.
enum Stream {
  kTileCounts,    // a tile: leaves, levels, groups, plain (0 or 1)
  kLeafColumns,   // from leaf to leaf
  kLeafCodes,     // less 1
  kLevelCounts,   // sums of a level
  kSumAnchors,    // lowest column of a sum, from sum to sum
  kSumRanks,      // of its first part among the entries with that lowest column
  kPartSteps,     // from its first part's lowest column to its second's
  kPartRanks,     // of its second part
  kGroupTerms,    // of a row of a group, from group to group
  kGroupRows,     // less 1
  kRowSteps,      // from row to row of a group
  kRowAnchors,    // lowest column of a row, from the tile's lowest
  kTermRanks,     // of each of its terms
  kTermSteps,     // from lowest column to lowest column
  kPlainColumns,  // of a row that is stored as it is: from column to column
  kPlainCodes,    // less 1
  kStreams
};
constexpr std::array<const char*, kStreams> kNames = {
    "tile_counts", "leaf_columns", "leaf_codes",    "level_counts", "sum_anchors", "sum_ranks",
    "part_steps",  "part_ranks",   "group_terms",   "group_rows",   "row_steps",   "row_anchors",
    "term_ranks",  "term_steps",   "plain_columns", "plain_codes"};

using Streams = std::array<std::vector<std::uint32_t>, kStreams>;

// The entries of a tile by their lowest column, in the order in which they come to be.
class Ranks {
 public:
  explicit Ranks(std::size_t columns) : by_column_(columns) {}
  void clear() {
    for (const std::uint16_t column : anchors_) by_column_[column].clear();
    anchors_.clear(), ranks_.clear();
  }
  void add(std::uint16_t anchor) {
    ranks_.push_back(static_cast<std::uint32_t>(by_column_[anchor].size()));
    by_column_[anchor].push_back(static_cast<std::uint32_t>(anchors_.size()));
    anchors_.push_back(anchor);
  }
  std::uint16_t anchor(std::uint32_t entry) const { return anchors_[entry]; }
  std::uint32_t rank(std::uint32_t entry) const { return ranks_[entry]; }
  // Out of range: none.
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::uint32_t entry(std::uint64_t anchor, std::uint32_t rank) const {
    return anchor < by_column_.size() && rank < by_column_[anchor].size() ? by_column_[anchor][rank] : kNone;
  }
  std::size_t size() const { return anchors_.size(); }

 private:
  std::vector<std::vector<std::uint32_t>> by_column_;
  std::vector<std::uint16_t> anchors_;
  std::vector<std::uint32_t> ranks_;
};

class Encoder {
 public:
  explicit Encoder(const SumGrammar& grammar) : grammar_(grammar), ranks_(grammar.columnCount()) {}

  Streams encode() {
    for (std::size_t tile = 0; tile < grammar_.tileCount(); ++tile) {
      begin_ = grammar_.tiles[tile], end_ = grammar_.tiles[tile + 1];
      const bool plain = begin_.leaf == end_.leaf;
      put(kTileCounts, end_.leaf - begin_.leaf), put(kTileCounts, end_.level - begin_.level);
      put(kTileCounts, end_.group - begin_.group), put(kTileCounts, plain ? 1 : 0);
      ranks_.clear();
      leaves();
      sums();
      groups(plain);
    }
    return std::move(streams_);
  }

 private:
  void put(Stream stream, std::uint64_t value) {
    streams_[stream].push_back(static_cast<std::uint32_t>(value));
  }

  void leaves() {
    std::uint16_t last = 0;
    for (std::uint64_t i = begin_.leaf; i < end_.leaf; ++i) {
      const std::uint16_t column = grammar_.leaf_columns[i];
      put(kLeafColumns, column - last), put(kLeafCodes, grammar_.leaf_codes[i] - 1U);
      last = column;
      ranks_.add(column);
    }
  }

  void sums() {
    std::uint32_t first = 0;
    for (std::uint64_t level = begin_.level; level < end_.level; ++level) {
      const std::uint32_t end = grammar_.level_ends[level];
      put(kLevelCounts, end - first);
      std::uint16_t last = 0;
      std::vector<std::uint16_t> anchors;
      for (; first < end; ++first) {
        const std::uint16_t* parts = &grammar_.sum_parts[2 * (begin_.sum + first)];
        const std::uint16_t anchor = ranks_.anchor(parts[0]);
        put(kSumAnchors, anchor - last), put(kSumRanks, ranks_.rank(parts[0]));
        put(kPartSteps, ranks_.anchor(parts[1]) - anchor - 1), put(kPartRanks, ranks_.rank(parts[1]));
        anchors.push_back(anchor);
        last = anchor;
      }
      for (const std::uint16_t anchor : anchors) ranks_.add(anchor);
    }
  }

  void groups(bool plain) {
    const std::uint16_t lowest = plain ? 0 : grammar_.leaf_columns[begin_.leaf];
    const std::uint16_t* term = grammar_.terms.data() + begin_.term;
    const std::uint8_t* code = grammar_.term_codes.data() + begin_.code;
    const std::uint32_t* row = grammar_.row_places.data() + begin_.row;
    std::uint32_t last_terms = 0;
    for (std::uint64_t g = begin_.group; g < end_.group; ++g) {
      const RowGroup group = grammar_.groups[g];
      put(kGroupTerms, group.terms - last_terms - 1), put(kGroupRows, group.rows - 1);
      last_terms = group.terms;
      for (std::uint32_t i = 0, last = 0; i < group.rows; ++i, ++row) {
        put(kRowSteps, *row - last);
        last = *row;
        std::uint16_t last_column = 0;
        for (std::uint32_t t = 0; t < group.terms; ++t, ++term) {
          if (plain) {
            put(kPlainColumns, *term - (t == 0 ? 0 : last_column + 1)), put(kPlainCodes, *code++ - 1U);
            last_column = *term;
            continue;
          }
          const std::uint16_t anchor = ranks_.anchor(*term);
          t == 0 ? put(kRowAnchors, anchor - lowest) : put(kTermSteps, anchor - last_column - 1);
          put(kTermRanks, ranks_.rank(*term));
          last_column = anchor;
        }
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
      : streams_(streams),
        grammar_(grammar),
        name_(name),
        ranks_(grammar.columnCount()),
        full_(grammar.subsamples * grammar.subsamples) {}

  void decode() {
    grammar_.tiles.push_back({});
    seen_.assign(grammar_.row_count, 0);
    while (next_[kTileCounts] < streams_[kTileCounts].size()) {
      const std::uint32_t leaf_count = get(kTileCounts), levels = get(kTileCounts),
                          group_count = get(kTileCounts);
      const bool plain = get(kTileCounts) != 0;
      if (plain != (leaf_count == 0)) fail(kTileCounts, "a tile of another kind than its leaves say");
      ranks_.clear();
      leaves(leaf_count);
      for (std::uint32_t level = 0; level < levels; ++level) sumsOfLevel(leaf_count);
      groups(group_count, plain);
      grammar_.tiles.push_back({grammar_.leaf_columns.size(), grammar_.sum_parts.size() / 2,
                                grammar_.level_ends.size(), grammar_.groups.size(), grammar_.terms.size(),
                                grammar_.term_codes.size(), grammar_.row_places.size()});
    }
    for (int stream = 0; stream < kStreams; ++stream)
      if (next_[stream] != streams_[stream].size())
        fail(static_cast<Stream>(stream), "values that belong to no tile");
  }

 private:
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
    const std::uint32_t found = ranks_.entry(anchor, get(stream));
    if (found == Ranks::kNone) fail(stream, "an entry that is not there");
    return static_cast<std::uint16_t>(found);
  }
  void add(Stream stream, std::uint16_t anchor) {
    if (ranks_.size() == kMostTileEntries) fail(stream, "more than 65536 entries of a tile");
    ranks_.add(anchor);
  }

  void leaves(std::uint32_t count) {
    std::uint64_t last = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      last = column(kLeafColumns, last + get(kLeafColumns));
      grammar_.leaf_columns.push_back(static_cast<std::uint16_t>(last));
      grammar_.leaf_codes.push_back(code(kLeafCodes));
      add(kLeafColumns, static_cast<std::uint16_t>(last));
    }
  }

  void sumsOfLevel(std::uint32_t leaf_count) {
    const std::uint32_t count = get(kLevelCounts);
    std::uint64_t anchor = 0;
    std::vector<std::uint16_t> anchors;
    for (std::uint32_t i = 0; i < count; ++i) {
      anchor = column(kSumAnchors, anchor + get(kSumAnchors));
      grammar_.sum_parts.push_back(entry(kSumRanks, anchor));
      const std::uint64_t second = anchor + get(kPartSteps) + 1;
      grammar_.sum_parts.push_back(entry(kPartRanks, second));
      anchors.push_back(static_cast<std::uint16_t>(anchor));
    }
    for (const std::uint16_t a : anchors) add(kSumAnchors, a);
    grammar_.level_ends.push_back(static_cast<std::uint32_t>(ranks_.size() - leaf_count));
  }

  void groups(std::uint32_t count, bool plain) {
    const std::uint64_t lowest = plain ? 0 : ranks_.anchor(0);
    std::uint64_t terms = 0;
    for (std::uint32_t g = 0; g < count; ++g) {
      terms += std::uint64_t{get(kGroupTerms)} + 1;
      if (terms > grammar_.columnCount()) fail(kGroupTerms, "a row of more terms than there are columns");
      const std::uint64_t rows = std::uint64_t{get(kGroupRows)} + 1;
      grammar_.groups.push_back({static_cast<std::uint32_t>(terms), static_cast<std::uint32_t>(rows)});
      std::uint64_t place = 0;
      for (std::uint64_t row = 0; row < rows; ++row) {
        place += get(kRowSteps);
        if (place >= grammar_.row_count || seen_[place] != 0)
          fail(kRowSteps, "a row beyond the matrix, or twice");
        seen_[place] = 1;
        grammar_.row_places.push_back(static_cast<std::uint32_t>(place));
        plain ? plainRow(terms) : row_(terms, lowest);
      }
    }
  }
  void row_(std::uint64_t terms, std::uint64_t lowest) {
    std::uint64_t anchor = lowest + get(kRowAnchors);
    for (std::uint64_t t = 0; t < terms; ++t) {
      if (t > 0) anchor += std::uint64_t{get(kTermSteps)} + 1;
      grammar_.terms.push_back(entry(kTermRanks, anchor));
    }
  }
  void plainRow(std::uint64_t terms) {
    std::uint64_t next = 0;
    for (std::uint64_t t = 0; t < terms; ++t) {
      const std::uint16_t at = column(kPlainColumns, next + get(kPlainColumns));
      grammar_.terms.push_back(at);
      grammar_.term_codes.push_back(code(kPlainCodes));
      next = std::uint64_t{at} + 1;
    }
  }

  const Streams& streams_;
  SumGrammar& grammar_;
  const std::string& name_;
  Ranks ranks_;
  int full_;
  std::array<std::size_t, kStreams> next_{};
  std::vector<std::uint8_t> seen_;
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
