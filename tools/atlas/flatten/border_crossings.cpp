#include "tools/atlas/flatten/border_crossings.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include "tools/atlas/maps/raster.h"

namespace bakelight::atlas {
namespace {

bool isBefore(const Vec2& a, const Vec2& b) {
  return std::tuple(a.x(), a.y()) < std::tuple(b.x(), b.y());
}

std::pair<Vec2, Vec2> ordered(const BorderSegment& s) {
  return isBefore(s.from, s.to) ? std::pair(s.from, s.to) : std::pair(s.to, s.from);
}

// Of a point on the line through the segment.
bool isInside(const Vec2& point, const BorderSegment& segment) {
  const auto [first, last] = ordered(segment);
  return isBefore(first, point) && isBefore(point, last);
}

bool overlapOnOneSide(const BorderSegment& a, const BorderSegment& b) {
  const auto [a_first, a_last] = ordered(a);
  const auto [b_first, b_last] = ordered(b);
  const bool overlap =
      isBefore(isBefore(a_first, b_first) ? b_first : a_first, isBefore(a_last, b_last) ? a_last : b_last);
  const int same_way = isBefore(a.from, a.to) == isBefore(b.from, b.to) ? 1 : -1;
  return overlap && a.inner_side * b.inner_side * same_way > 0;
}

// Buckets of the square, one segment in each of those that it runs through.
class Buckets {
 public:
  explicit Buckets(std::span<const BorderSegment> borders)
      : borders_(borders),
        side_(std::clamp(static_cast<int>(std::sqrt(static_cast<double>(borders.size()))), 1, 2048)),
        buckets_(static_cast<std::size_t>(side_) * side_) {
    for (std::uint32_t s = 0; s < borders.size(); ++s)
      for (int row = firstRow(s); row <= lastRow(s); ++row) {
        const auto [first, last] = columns(s, row);
        for (int column = first; column <= last; ++column) bucket(row, column).push_back(s);
      }
  }

  int side() const { return side_; }
  std::vector<std::uint32_t>& bucket(int row, int column) {
    return buckets_[static_cast<std::size_t>(row) * side_ + column];
  }

  // Whether this is the first bucket that holds both: pairs are looked at once.
  bool isFirstOf(std::uint32_t a, std::uint32_t b, int row, int column) const {
    for (int r = std::max(firstRow(a), firstRow(b)); r < row; ++r)
      if (firstColumn(a, b, r) <= lastColumn(a, b, r)) return false;
    return firstColumn(a, b, row) == column;
  }

 private:
  int slot(double coordinate) const {
    return static_cast<int>(std::clamp(coordinate * side_, 0.0, side_ - 1.0));
  }
  int firstRow(std::uint32_t s) const { return slot(std::min(borders_[s].from.y(), borders_[s].to.y())); }
  int lastRow(std::uint32_t s) const { return slot(std::max(borders_[s].from.y(), borders_[s].to.y())); }

  // A little wider than the segment in that row, as the crossings with its lines are rounded.
  std::pair<int, int> columns(std::uint32_t s, int row) const {
    constexpr double kMargin = 1e-9;
    const Vec2 &a = borders_[s].from, &b = borders_[s].to;
    const double rise = b.y() - a.y();
    double begin = 0, end = 1;  // along the segment
    if (rise != 0) {
      // The outer rows take what lies outside the square, too.
      const double low = row == 0 ? -1e300 : static_cast<double>(row) / side_;
      const double high = row == side_ - 1 ? 1e300 : static_cast<double>(row + 1) / side_;
      const auto [enter, leave] = std::minmax({(low - a.y()) / rise, (high - a.y()) / rise});
      begin = std::clamp(enter, 0.0, 1.0), end = std::clamp(leave, 0.0, 1.0);
    }
    const double from = a.x() + begin * (b.x() - a.x()), to = a.x() + end * (b.x() - a.x());
    return {slot(std::min(from, to) - kMargin), slot(std::max(from, to) + kMargin)};
  }
  int firstColumn(std::uint32_t a, std::uint32_t b, int row) const {
    return std::max(columns(a, row).first, columns(b, row).first);
  }
  int lastColumn(std::uint32_t a, std::uint32_t b, int row) const {
    return std::min(columns(a, row).second, columns(b, row).second);
  }

  std::span<const BorderSegment> borders_;
  int side_;
  std::vector<std::vector<std::uint32_t>> buckets_;
};

}  // namespace

bool bordersCross(const BorderSegment& a, const BorderSegment& b) {
  const int from_side = orientationOf(a.from, a.to, b.from), to_side = orientationOf(a.from, a.to, b.to);
  if (from_side * to_side > 0) return false;
  if (from_side == 0 && to_side == 0) return overlapOnOneSide(a, b);
  const int a_from_side = orientationOf(b.from, b.to, a.from), a_to_side = orientationOf(b.from, b.to, a.to);
  if (from_side * to_side < 0 && a_from_side * a_to_side < 0) return true;
  const auto entersAt = [](const BorderSegment& other, const Vec2& end, int end_side, int far_end_side) {
    return end_side == 0 && far_end_side * other.inner_side > 0 && isInside(end, other);
  };
  return entersAt(a, b.from, from_side, to_side) || entersAt(a, b.to, to_side, from_side) ||
         entersAt(b, a.from, a_from_side, a_to_side) || entersAt(b, a.to, a_to_side, a_from_side);
}

std::int64_t countCrossings(std::span<const BorderSegment> borders, std::int64_t most) {
  Buckets buckets(borders);
  std::int64_t count = 0;
  for (int row = 0; row < buckets.side(); ++row)
    for (int column = 0; column < buckets.side(); ++column) {
      const std::vector<std::uint32_t>& inside = buckets.bucket(row, column);
      for (std::size_t i = 0; i < inside.size(); ++i)
        for (std::size_t k = i + 1; k < inside.size(); ++k) {
          if (!bordersCross(borders[inside[i]], borders[inside[k]]) ||
              !buckets.isFirstOf(inside[i], inside[k], row, column))
            continue;
          if (++count == most) return count;
        }
    }
  return count;
}

}  // namespace bakelight::atlas
