#include <algorithm>
#include <bit>

#include "compression/symbol_lists.h"

namespace bakelight::compression {
namespace {

constexpr int kSquareLevels = 6;  // halvings of 8 × 8 texels

struct Slice {
  std::uint32_t list;
  std::uint32_t begin, end;  // of the tile's texels
};

// Counts of hashes; the slot of a hash stays what it is.
class HashCounts {
 public:
  explicit HashCounts(std::size_t most) : slots_(std::bit_ceil(2 * most + 2)) {}

  std::uint32_t count(std::uint64_t hash) {
    std::size_t at = (hash ^ hash >> 32) & (slots_.size() - 1);
    while (slots_[at].count != 0 && slots_[at].hash != hash) at = (at + 1) & (slots_.size() - 1);
    slots_[at].hash = hash;
    ++slots_[at].count;
    return static_cast<std::uint32_t>(at);
  }
  std::uint32_t countAt(std::uint32_t slot) const { return slots_[slot].count; }
  Symbol& symbolAt(std::uint32_t slot) { return slots_[slot].symbol; }

 private:
  struct Slot {
    std::uint64_t hash = 0;
    std::uint32_t count = 0;
    Symbol symbol = ~Symbol{0};
  };
  std::vector<Slot> slots_;
};

class Cutter {
 public:
  Cutter(const TileTexels& texels, std::uint32_t least_uses) : texels_(texels), least_uses_(least_uses) {
    sums_of_hashes_.resize(texels.leaves.size() + 1);
    for (std::size_t i = 0; i < texels.leaves.size(); ++i)
      sums_of_hashes_[i + 1] = sums_of_hashes_[i] + texels.leaf_hashes[texels.leaves[i]];
    lists_.leaves = texels.leaf_hashes.size();
    lists_.rows = texels.row_begins.size() - 1;
    lists_.hashes = texels.leaf_hashes;
    list_count_ = static_cast<std::uint32_t>(lists_.rows);
  }

  SymbolLists cut() {
    startWithSquares();
    for (int level = kSquareLevels; level > 0; --level) halve(level);
    for (const Slice& slice : slices_) emit(slice.list, texels_.leaves[slice.begin]);
    gather();
    return std::move(lists_);
  }

 private:
  void startWithSquares() {
    for (std::uint32_t row = 0; row < lists_.rows; ++row) {
      const std::uint32_t end = texels_.row_begins[row + 1];
      for (std::uint32_t begin = texels_.row_begins[row]; begin < end;) {
        std::uint32_t next = begin + 1;
        while (next < end && places(next, kSquareLevels) == places(begin, kSquareLevels)) ++next;
        slices_.push_back({row, begin, next});
        begin = next;
      }
    }
  }

  // Slices lie in one cell of `level` each; those that lie in one half of it go on as they are.
  void halve(int level) {
    std::vector<std::uint32_t> slots(slices_.size(), kInOneHalf);
    HashCounts counts(slices_.size());
    for (std::size_t i = 0; i < slices_.size(); ++i)
      if (places(slices_[i].begin, level - 1) != places(slices_[i].end - 1, level - 1))
        slots[i] = counts.count(hashOf(slices_[i]));
    std::vector<Slice> halves;
    halves.reserve(2 * slices_.size());
    for (std::size_t i = 0; i < slices_.size(); ++i) {
      Slice slice = slices_[i];
      if (slots[i] == kInOneHalf) {
        halves.push_back(slice);
        continue;
      }
      if (counts.countAt(slots[i]) >= least_uses_) {
        Symbol& symbol = counts.symbolAt(slots[i]);
        const bool known = symbol != ~Symbol{0};
        if (!known) symbol = newSum(hashOf(slice));
        emit(slice.list, symbol);
        if (known) continue;
        slice.list = list_count_ - 1;
      }
      const std::uint32_t middle = middleOf(slice, level);
      halves.push_back({slice.list, slice.begin, middle});
      halves.push_back({slice.list, middle, slice.end});
    }
    slices_.swap(halves);
  }

  std::uint32_t middleOf(const Slice& slice, int level) const {
    std::uint32_t middle = slice.begin + 1;
    while (places(middle, level - 1) == places(slice.begin, level - 1)) ++middle;
    return middle;
  }
  std::uint32_t places(std::uint32_t texel, int level) const { return texels_.places[texel] >> level; }
  std::uint64_t hashOf(const Slice& slice) const {
    return sums_of_hashes_[slice.end] - sums_of_hashes_[slice.begin];
  }
  Symbol newSum(std::uint64_t hash) {
    ++list_count_;
    lists_.hashes.push_back(hash);
    return static_cast<Symbol>(lists_.hashes.size() - 1);
  }
  void emit(std::uint32_t list, Symbol symbol) { emitted_.push_back({list, symbol}); }

  // Into lists, their symbols ascending.
  void gather() {
    lists_.begins.assign(list_count_ + 1, 0);
    for (const Emitted& emitted : emitted_) ++lists_.begins[emitted.list + 1];
    for (std::uint32_t i = 0; i < list_count_; ++i) lists_.begins[i + 1] += lists_.begins[i];
    std::vector<std::uint32_t> next(lists_.begins.begin(), lists_.begins.end() - 1);
    lists_.symbols.resize(emitted_.size());
    for (const Emitted& emitted : emitted_) lists_.symbols[next[emitted.list]++] = emitted.symbol;
    for (std::uint32_t i = 0; i < list_count_; ++i)
      std::sort(lists_.symbols.begin() + lists_.begins[i], lists_.symbols.begin() + lists_.begins[i + 1]);
  }

  struct Emitted {
    std::uint32_t list;
    Symbol symbol;
  };
  static constexpr std::uint32_t kInOneHalf = ~std::uint32_t{0};

  const TileTexels& texels_;
  std::uint32_t least_uses_;
  std::vector<std::uint64_t> sums_of_hashes_;
  std::vector<Slice> slices_;
  std::vector<Emitted> emitted_;
  SymbolLists lists_;
  std::uint32_t list_count_ = 0;
};

}  // namespace

SymbolLists cutIntoPieces(const TileTexels& texels, std::uint32_t least_uses) {
  return Cutter(texels, least_uses).cut();
}

}  // namespace bakelight::compression
