// What points see of the surface: sparse rows, held in blocks as they come from the rays.
//
// A row may be held exactly, 8 bytes a share; with shares of 16 bits, 6 bytes; and with the small ones of
// them put together. None of these makes or loses light: the sum of a row stays.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace bakelight::transport {

// Weight that falls to one vertex of what a point sees. The back side of vertex v is v + vertex count.
struct SeenVertex {
  std::uint32_t side;
  float weight;
  bool operator==(const SeenVertex&) const = default;
};

// Sums of weights by side, for the few sides that one point sees: a hash table of a size that does not go by
// the mesh's.
class SeenSums {
 public:
  // Room for so many sides at a time.
  explicit SeenSums(std::size_t most_sides);
  void add(std::uint32_t side, float weight);
  // Sorted by side; empties the table. Each sum was added up in the order of the calls.
  std::vector<SeenVertex> take();

 private:
  std::vector<SeenVertex> slots_;
  std::vector<std::uint32_t> used_;
  int shift_;
};

// How rows are held.
struct ShareStorage {
  bool exact = true;    // weights as floats; else as 16 bits of the row's largest
  float threshold = 0;  // > 0: smaller weights are put together (putSmallTogether)

  std::size_t bytesPerShare() const { return sizeof(std::uint32_t) + (exact ? 4 : 2); }
};

// Weights below `threshold` give way to fewer and equal ones of about that size, their sum divided evenly,
// which go to every so much of the sum in the order of sides: a side is given one with a chance in proportion
// to its weight (systematic sampling; the lot that decides is drawn from the row itself). The row keeps its
// sum and its order.
void putSmallTogether(std::vector<SeenVertex>& row, float threshold);
// Entries that it would leave.
std::size_t countPutTogether(std::span<const SeenVertex> row, float threshold);

// Columns are sides as the rays find them until `renumber`, then rows of the solver's tables.
class FormFactors {
 public:
  explicit FormFactors(ShareStorage storage = {}) : storage_(storage) {}

  struct Block {
    std::vector<std::uint32_t> row_begin = {0};  // rows + 1
    std::vector<std::uint32_t> columns;          // ascending within a row
    std::vector<float> weights;                  // exact
    std::vector<std::uint16_t> codes;            // else: a weight is code × unit of its row
    std::vector<float> units;

    std::size_t rowCount() const { return row_begin.size() - 1; }
    std::span<const std::uint32_t> columnsOf(std::size_t row) const {
      return std::span(columns).subspan(row_begin[row], row_begin[row + 1] - row_begin[row]);
    }
    // In `decoded` unless they are held as floats.
    std::span<const float> weightsOf(std::size_t row, std::vector<float>& decoded) const;
  };

  // Rows as they are held here. Thread-safe.
  Block packed(std::span<const std::vector<SeenVertex>> rows) const;
  // The rows of the next points.
  void append(Block block);
  void append(FormFactors&& next);
  void replace(std::size_t row, std::vector<SeenVertex> seen);
  // Every column c becomes row_of_side[c].
  void renumber(std::span<const std::uint32_t> row_of_side);

  const ShareStorage& storage() const { return storage_; }
  std::size_t rowCount() const {
    return first_rows_.empty() ? 0 : first_rows_.back() + blocks_.back().rowCount();
  }
  std::uint64_t shareCount() const;
  std::size_t bytes() const;
  std::size_t blockCount() const { return blocks_.size(); }
  const Block& block(std::size_t i) const { return blocks_[i]; }
  std::size_t firstRow(std::size_t block) const { return first_rows_[block]; }
  std::vector<SeenVertex> row(std::size_t row) const;

 private:
  std::size_t blockOf(std::size_t row) const;

  ShareStorage storage_;
  std::vector<Block> blocks_;
  std::vector<std::size_t> first_rows_;
};

}  // namespace bakelight::transport
