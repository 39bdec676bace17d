#include "tools/player/techniques/pixel_product.h"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "formats/error.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gpu_table.h"

namespace bakelight::player {
namespace {

constexpr std::uint32_t kMostGroups = 65535;  // that GL dispatches at once, at least
constexpr std::uint32_t kNoRow = ~std::uint32_t{0};
constexpr GLbitfield kTableBarriers = GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT;
constexpr std::size_t kEntryBytes = sizeof(formats::Float4);

Buffer bufferOf(const std::vector<std::uint32_t>& values) {
  return makeBuffer(values.size() * sizeof(values[0]), values.empty() ? nullptr : values.data());
}

void bind(GLuint binding, const Buffer& buffer) {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer.name());
}

}  // namespace

RowProduct::RowProduct(const formats::PixelCodes& codes, std::size_t most_bytes)
    : program_(makeComputeProgram({kPixelTransferComp})) {
  const std::size_t cells = static_cast<std::size_t>(codes.local_side) * codes.local_side;
  for (std::size_t row = 0; row < codes.rowCount();) {
    Rows rows;
    rows.first = row;
    const std::uint64_t first = codes.row_offsets[row];
    const auto entriesTo = [&](std::size_t end) { return codes.row_offsets[end] - first; };
    do row += cells;
    while (row < codes.rowCount() && entriesTo(row + cells) * sizeof(std::uint32_t) <= most_bytes &&
           row + cells - rows.first <= kMostGroups * kGroupSize);
    rows.count = row - rows.first;
    std::vector<std::uint32_t> offsets, entries;
    for (std::size_t i = rows.first; i <= row; ++i)
      offsets.push_back(static_cast<std::uint32_t>(codes.row_offsets[i] - first));
    entries.reserve(entriesTo(row));
    for (std::uint64_t i = first; i < first + entriesTo(row); ++i)
      entries.push_back(codes.columns[i] | static_cast<std::uint32_t>(codes.codes[i]) << 16);
    rows.offsets = bufferOf(offsets);
    rows.entries = bufferOf(entries);
    rows_.push_back(std::move(rows));
  }
}

void RowProduct::run(const Buffer& light, const Buffer& incident) const {
  glUseProgram(program_.name());
  bind(0, light), bind(3, incident);
  for (const Rows& rows : rows_) {
    bind(1, rows.offsets), bind(2, rows.entries);
    glUniform1ui(0, static_cast<GLuint>(rows.count));
    glUniform1ui(1, static_cast<GLuint>(rows.first));
    dispatchItems(rows.count);
  }
}

std::size_t RowProduct::gpuBytes() const {
  std::size_t bytes = 0;
  for (const Rows& rows : rows_) bytes += sizeInBytes(rows.offsets) + sizeInBytes(rows.entries);
  return bytes;
}

// Tiles whose tables are one. Numbers of entries are the table's: 0, then leaves tile by tile, then sums level by level.
class SumProduct::PartMaker {
 public:
  PartMaker(const formats::SumGrammar& grammar, std::size_t first_tile, std::size_t end_tile,
            std::size_t most_bytes)
      : grammar_(grammar), first_tile_(first_tile), end_tile_(end_tile), most_bytes_(most_bytes) {}

  // At most: leaves of a tile as it is are not counted apart.
  static std::size_t entriesOf(const formats::SumGrammar& grammar, std::size_t tile) {
    const formats::SumTile &begin = grammar.tiles[tile], &end = grammar.tiles[tile + 1];
    return (end.leaf - begin.leaf) + (end.sum - begin.sum) + (end.code - begin.code);
  }

  Part make(std::size_t& entries) {
    entries_.resize(end_tile_ - first_tile_);
    for (std::size_t tile = first_tile_; tile < end_tile_; ++tile) addLeaves(tile);
    part_.leaf_count = static_cast<std::uint32_t>(leaves_.size());
    part_.leaves = bufferOf(leaves_);
    next_ = part_.leaf_count + 1;
    for (std::size_t level = 0; addLevel(level);) ++level;
    part_.sums = bufferOf(sums_);
    for (std::size_t tile = first_tile_; tile < end_tile_; ++tile) addRows(tile);
    finishSlices();
    entries = next_;
    return std::move(part_);
  }

 private:
  struct Tile {
    std::vector<std::uint32_t> entries;                     // in the table, of the tile's own
    std::map<std::uint32_t, std::uint32_t> entry_of_texel;  // as it is: of a column and a code
  };

  std::uint32_t addLeaf(std::uint32_t column, std::uint32_t code) {
    leaves_.push_back(column | code << 16);
    return static_cast<std::uint32_t>(leaves_.size());
  }

  void addLeaves(std::size_t tile) {
    const formats::SumTile &begin = grammar_.tiles[tile], &end = grammar_.tiles[tile + 1];
    Tile& entries = entries_[tile - first_tile_];
    for (std::uint64_t i = begin.leaf; i < end.leaf; ++i)
      entries.entries.push_back(addLeaf(grammar_.leaf_columns[i], grammar_.leaf_codes[i]));
    for (std::uint64_t i = 0; i < end.code - begin.code; ++i) {
      const std::uint32_t column = grammar_.terms[begin.term + i], code = grammar_.term_codes[begin.code + i];
      auto [texel, is_new] = entries.entry_of_texel.try_emplace(column | code << 16);
      if (is_new) texel->second = addLeaf(column, code);
    }
  }

  // False if no tile has such a level.
  bool addLevel(std::size_t level) {
    Level added{next_, 0};
    bool is_there = false;
    for (std::size_t tile = first_tile_; tile < end_tile_; ++tile) {
      const formats::SumTile &begin = grammar_.tiles[tile], &end = grammar_.tiles[tile + 1];
      if (begin.level + level >= end.level) continue;
      is_there = true;
      std::vector<std::uint32_t>& entries = entries_[tile - first_tile_].entries;
      const std::uint32_t first = level == 0 ? 0 : grammar_.level_ends[begin.level + level - 1];
      for (std::uint64_t i = first; i < grammar_.level_ends[begin.level + level]; ++i) {
        for (std::size_t part = 0; part < 2; ++part)
          sums_.push_back(entries[grammar_.sum_parts[2 * (begin.sum + i) + part]]);
        entries.push_back(next_++);
      }
    }
    added.count = next_ - added.first;
    if (added.count > 0) part_.levels.push_back(added);
    return is_there;
  }

  struct RowTerms {
    std::uint32_t place, length;
    std::uint64_t term, code;
  };

  void addRows(std::size_t tile) {
    const formats::SumTile &begin = grammar_.tiles[tile], &end = grammar_.tiles[tile + 1];
    std::uint64_t term = begin.term, code = begin.code, row = begin.row;
    std::vector<RowTerms> slice;
    for (std::uint64_t group = begin.group; group < end.group; ++group)
      for (std::uint32_t i = 0; i < grammar_.groups[group].rows; ++i) {
        const std::uint32_t length = grammar_.groups[group].terms;
        slice.push_back({grammar_.row_places[row++], length, term, code});
        term += length, code += length;
        if (slice.size() == kGroupSize) addSlice(tile, slice);
      }
    if (!slice.empty()) addSlice(tile, slice);
  }

  void addSlice(std::size_t tile, std::vector<RowTerms>& slice) {
    const std::size_t length = slice.back().length;  // the longest
    if ((terms_.size() + length * kGroupSize) * sizeof(std::uint32_t) > most_bytes_ ||
        begins_.size() > kMostGroups)
      finishSlices();
    for (std::size_t t = 0; t < length; ++t)
      for (std::size_t i = 0; i < kGroupSize; ++i)
        terms_.push_back(i < slice.size() && t < slice[i].length ? entryOf(tile, slice[i], t) : 0);
    begins_.push_back(static_cast<std::uint32_t>(terms_.size()));
    for (std::size_t i = 0; i < kGroupSize; ++i)
      places_.push_back(i < slice.size() ? slice[i].place : kNoRow);
    slice.clear();
  }

  std::uint32_t entryOf(std::size_t tile, const RowTerms& row, std::size_t t) const {
    const Tile& entries = entries_[tile - first_tile_];
    const std::uint32_t term = grammar_.terms[row.term + t];
    if (entries.entry_of_texel.empty()) return entries.entries[term];
    return entries.entry_of_texel.at(term | std::uint32_t{grammar_.term_codes[row.code + t]} << 16);
  }

  void finishSlices() {
    if (begins_.size() > 1)
      part_.slices.push_back({static_cast<std::uint32_t>(begins_.size() - 1), bufferOf(begins_),
                              bufferOf(terms_), bufferOf(places_)});
    begins_ = {0};
    terms_.clear(), places_.clear();
  }

  const formats::SumGrammar& grammar_;
  std::size_t first_tile_, end_tile_, most_bytes_;
  Part part_;
  std::vector<Tile> entries_;
  std::vector<std::uint32_t> leaves_, sums_, begins_ = {0}, terms_, places_;
  std::uint32_t next_ = 1;
};

SumProduct::SumProduct(const formats::SumGrammar& grammar, std::size_t most_bytes)
    : leaves_program_(makeComputeProgram({kPixelLeavesComp})),
      sums_program_(makeComputeProgram({kPixelSumsComp})),
      rows_program_(makeComputeProgram({kPixelRowsComp})) {
  GLint most_texels = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most_texels);
  const std::size_t most_table = std::min(most_bytes / kEntryBytes, static_cast<std::size_t>(most_texels));
  std::size_t most_entries = 1;
  for (std::size_t tile = 0; tile < grammar.tileCount();) {
    const std::size_t first = tile;
    std::size_t entries = 1;
    do entries += PartMaker::entriesOf(grammar, tile++);
    while (tile < grammar.tileCount() && entries + PartMaker::entriesOf(grammar, tile) <= most_table);
    parts_.push_back(PartMaker(grammar, first, tile, most_bytes).make(entries));
    most_entries = std::max(most_entries, entries);
  }
  if (most_entries > static_cast<std::size_t>(most_texels))
    throw badInput({"", "pixel transfer", ""}, "a tile has " + std::to_string(most_entries) + " sums",
                   "at most " + std::to_string(most_texels) + " on this GPU",
                   "fewer rows_per_tile in bicluster");
  const std::vector<formats::Float4> zeros(most_entries, formats::Float4{0, 0, 0, 0});
  table_ = makeBuffer(most_entries * kEntryBytes, zeros.data());
  table_texels_ = makeBufferTexture(GL_RGBA32F, table_);
}

void SumProduct::run(const Buffer& light, const Buffer& incident) const {
  bind(0, light), bind(1, table_), bind(2, incident);
  glBindTextureUnit(0, table_texels_.name());
  for (const Part& part : parts_) {
    glUseProgram(leaves_program_.name());
    bind(3, part.leaves);
    glUniform1ui(0, part.leaf_count);
    dispatchItems(part.leaf_count);
    glUseProgram(sums_program_.name());
    bind(3, part.sums);
    for (const Level& level : part.levels) {
      glMemoryBarrier(kTableBarriers);
      glUniform1ui(0, level.first);
      glUniform1ui(1, level.count);
      glUniform1ui(2, level.first - part.leaf_count - 1);
      dispatchItems(level.count);
    }
    glMemoryBarrier(kTableBarriers);
    glUseProgram(rows_program_.name());
    for (const Slices& slices : part.slices) {
      bind(3, slices.begins), bind(4, slices.terms), bind(5, slices.places);
      dispatchItems(slices.count * kGroupSize);
    }
    // The next part's leaves take this one's place in the table.
    glMemoryBarrier(kTableBarriers);
  }
}

std::size_t SumProduct::gpuBytes() const {
  std::size_t bytes = sizeInBytes(table_);
  for (const Part& part : parts_) {
    bytes += sizeInBytes(part.leaves) + sizeInBytes(part.sums);
    for (const Slices& slices : part.slices)
      bytes += sizeInBytes(slices.begins) + sizeInBytes(slices.terms) + sizeInBytes(slices.places);
  }
  return bytes;
}

std::unique_ptr<PixelProduct> makePixelProduct(const formats::PixelTransfer& transfer) {
  if (!transfer.sums) return std::make_unique<RowProduct>(formats::PixelTransferRows(transfer).view());
  if (transfer.sums->grammar == nullptr)
    throw std::invalid_argument("the sums of transfer in a pixel basis were not decoded");
  return std::make_unique<SumProduct>(*transfer.sums->grammar);
}

}  // namespace bakelight::player
