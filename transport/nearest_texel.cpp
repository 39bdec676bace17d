#include "transport/nearest_texel.h"

#include <tbb/parallel_for.h>

namespace bakelight::transport {
namespace {

constexpr std::int32_t kNone = -1;

// For each texel of a column the row of the nearest member of that column, of two the upper one.
void nearestInColumn(std::span<const std::uint8_t> members, int width, int height, int x,
                     std::vector<std::int32_t>& rows) {
  const auto at = [&](int y) { return static_cast<std::size_t>(y) * width + x; };
  std::int32_t above = kNone;
  for (int y = 0; y < height; ++y) {
    if (members[at(y)] != 0) above = y;
    rows[at(y)] = above;
  }
  std::int32_t below = kNone;
  for (int y = height - 1; y >= 0; --y) {
    if (members[at(y)] != 0) below = y;
    std::int32_t& row = rows[at(y)];
    if (below != kNone && (row == kNone || below - y < y - row)) row = below;
  }
}

// One row: columns whose nearest member is nearest for some texel of the row, from left to right.
class LowerEnvelope {
 public:
  LowerEnvelope(const std::int32_t* nearest_rows, int width, int y) : rows_(nearest_rows), y_(y) {
    for (int column = 0; column < width; ++column)
      if (rows_[column] != kNone) add(column, width);
  }

  // Calls visit(x, column) for each x from left to right.
  template <class Visit>
  void forEach(int width, const Visit& visit) const {
    std::size_t part = 0;
    for (int x = 0; x < width; ++x) {
      while (part + 1 < parts_.size() && parts_[part + 1].begin <= x) ++part;
      visit(x, parts_[part].column);
    }
  }

 private:
  struct Part {
    int column, begin;  // nearest from texel `begin` on
  };

  std::int64_t squaredDistance(int x, int column) const {
    const std::int64_t dx = x - column, dy = y_ - rows_[column];
    return dx * dx + dy * dy;
  }

  // The first x at which `right` is nearer than `left`: behind the last where it is not, which there is, as
  // `left` begins where it is not. So the quotient is not negative.
  std::int64_t firstNearer(int left, int right) const {
    const std::int64_t left_dy = y_ - rows_[left], right_dy = y_ - rows_[right];
    const std::int64_t numerator = static_cast<std::int64_t>(right) * right -
                                   static_cast<std::int64_t>(left) * left + right_dy * right_dy -
                                   left_dy * left_dy;
    return numerator / (2 * static_cast<std::int64_t>(right - left)) + 1;
  }

  void add(int column, int width) {
    while (!parts_.empty() && squaredDistance(parts_.back().begin, parts_.back().column) >
                                  squaredDistance(parts_.back().begin, column))
      parts_.pop_back();
    const std::int64_t begin = parts_.empty() ? 0 : firstNearer(parts_.back().column, column);
    if (begin < width) parts_.push_back({column, static_cast<int>(begin)});
  }

  const std::int32_t* rows_;
  int y_;
  std::vector<Part> parts_;
};

}  // namespace

std::vector<std::uint32_t> nearestTexels(std::span<const std::uint8_t> members, int width, int height) {
  std::vector<std::int32_t> rows(members.size());
  tbb::parallel_for(0, width, [&](int x) { nearestInColumn(members, width, height, x, rows); });
  std::vector<std::uint32_t> nearest(members.size());
  tbb::parallel_for(0, height, [&](int y) {
    const std::size_t first = static_cast<std::size_t>(y) * width;
    LowerEnvelope(&rows[first], width, y).forEach(width, [&](int x, int column) {
      nearest[first + x] = static_cast<std::uint32_t>(rows[first + column]) * width + column;
    });
  });
  return nearest;
}

}  // namespace bakelight::transport
