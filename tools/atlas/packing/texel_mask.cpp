#include "tools/atlas/packing/texel_mask.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace bakelight::atlas {
namespace {

int firstCell(double coordinate, const CellGrowth& growth) {
  return static_cast<int>(std::floor(coordinate - growth.high));
}
int lastCell(double coordinate, const CellGrowth& growth) {
  return static_cast<int>(std::ceil(coordinate + growth.low)) - 1;
}

// Intervals collected in any order and by any row, then merged.
class RowIntervals {
 public:
  void add(int row, Span span) {
    if (span.begin < span.end) entries_.push_back({row, span});
  }

  // Overlapping and adjacent spans become one.
  TexelMask mask() const {
    TexelMask mask;
    if (entries_.empty()) {
      mask.row_begins = {0};
      return mask;
    }
    int bottom = entries_[0].row, top = bottom, left = entries_[0].span.begin;
    for (const Entry& entry : entries_) {
      bottom = std::min(bottom, entry.row);
      top = std::max(top, entry.row);
      left = std::min(left, entry.span.begin);
    }
    std::vector<std::uint32_t> begins(static_cast<std::size_t>(top - bottom) + 2, 0);
    for (const Entry& entry : entries_) ++begins[entry.row - bottom + 1];
    for (std::size_t r = 1; r < begins.size(); ++r) begins[r] += begins[r - 1];
    std::vector<Span> sorted(entries_.size());
    std::vector<std::uint32_t> cursors(begins.begin(), begins.end() - 1);
    for (const Entry& entry : entries_)
      sorted[cursors[entry.row - bottom]++] = {entry.span.begin - left, entry.span.end - left};

    mask.left = left;
    mask.bottom = bottom;
    mask.height = top - bottom + 1;
    mask.row_begins.reserve(begins.size());
    mask.row_begins.push_back(0);
    for (int r = 0; r < mask.height; ++r) {
      const auto first = sorted.begin() + begins[r], last = sorted.begin() + begins[r + 1];
      std::sort(first, last, [](const Span& a, const Span& b) { return a.begin < b.begin; });
      for (auto it = first; it != last; ++it) {
        if (mask.spans.size() > mask.row_begins.back() && it->begin <= mask.spans.back().end)
          mask.spans.back().end = std::max(mask.spans.back().end, it->end);
        else
          mask.spans.push_back(*it);
        mask.width = std::max(mask.width, it->end);
      }
      mask.row_begins.push_back(static_cast<std::uint32_t>(mask.spans.size()));
    }
    return mask;
  }

 private:
  struct Entry {
    int row;
    Span span;
  };
  std::vector<Entry> entries_;
};

void addEdge(const Vec2& a, const Vec2& b, const CellGrowth& growth, RowIntervals& intervals) {
  const Vec2 &low = a.y() <= b.y() ? a : b, &high = a.y() <= b.y() ? b : a;
  const double slope = high.y() > low.y() ? (high.x() - low.x()) / (high.y() - low.y()) : 0;
  const double x_min = std::min(a.x(), b.x()), x_max = std::max(a.x(), b.x());
  const auto xAt = [&](double y) { return std::clamp(low.x() + (y - low.y()) * slope, x_min, x_max); };
  const int last = lastCell(high.y(), growth);
  for (int row = firstCell(low.y(), growth); row <= last; ++row) {
    const double below = row - growth.low, above = row + 1 + growth.high;
    const double x0 = below <= low.y() ? low.x() : xAt(below);
    const double x1 = above >= high.y() ? high.x() : xAt(above);
    intervals.add(row, {firstCell(std::min(x0, x1), growth), lastCell(std::max(x0, x1), growth) + 1});
  }
}

struct Crossing {
  int row;
  double x;
  int winding;
};

// Where edges cross the lines through the rows' centres. A vertex on a line belongs to the part above.
void addCrossings(const Vec2& a, const Vec2& b, std::vector<Crossing>& crossings) {
  const bool up = a.y() <= b.y();
  const Vec2 &low = up ? a : b, &high = up ? b : a;
  for (int row = static_cast<int>(std::ceil(low.y() - 0.5)); row + 0.5 < high.y(); ++row) {
    const double t = (row + 0.5 - low.y()) / (high.y() - low.y());
    crossings.push_back({row, low.x() + t * (high.x() - low.x()), up ? -1 : 1});
  }
}

// Texels that no edge touches are inside or outside as their centres are.
void addInside(std::vector<Crossing>& crossings, RowIntervals& intervals) {
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    return a.row < b.row || (a.row == b.row && a.x < b.x);
  });
  int winding = 0;
  for (std::size_t i = 0; i + 1 < crossings.size(); ++i) {
    winding += crossings[i].winding;
    if (winding != 0 && crossings[i].row == crossings[i + 1].row)
      intervals.add(crossings[i].row, {static_cast<int>(std::ceil(crossings[i].x - 0.5)),
                                       static_cast<int>(std::ceil(crossings[i + 1].x - 0.5))});
  }
}

}  // namespace

std::int64_t TexelMask::texelCount() const {
  std::int64_t count = 0;
  for (const Span& span : spans) count += span.end - span.begin;
  return count;
}

std::vector<Vec2> placedVertices(const ChartOutline& outline, double texels_per_unit,
                                 const Placement& placement) {
  const double c = texels_per_unit * std::cos(placement.angle_rad);
  const double s = texels_per_unit * std::sin(placement.angle_rad);
  std::vector<Vec2> points;
  points.reserve(outline.vertices.size());
  for (const Vec2& p : outline.vertices)
    points.emplace_back(c * p.x() - s * p.y() + placement.offset.x(),
                        s * p.x() + c * p.y() + placement.offset.y());
  return points;
}

TexelMask texelsOf(const ChartOutline& outline, const std::vector<Vec2>& points, const CellGrowth& growth) {
  RowIntervals intervals;
  std::vector<Crossing> crossings;
  for (const auto& [from, to] : outline.edges) {
    addEdge(points[from], points[to], growth, intervals);
    addCrossings(points[from], points[to], crossings);
  }
  addInside(crossings, intervals);
  return intervals.mask();
}

TurnedChart turnedChart(const ChartOutline& outline, double texels_per_unit, double angle_rad,
                        const CellGrowth& growth) {
  TurnedChart turned;
  turned.angle_rad = angle_rad;
  const auto [low, high] = turnedBox(outline.hull, angle_rad);
  const Vec2 extent = texels_per_unit * (high - low);
  for (int axis = 0; axis < 2; ++axis) {
    const double cells = extent[axis] + growth.low + growth.high;
    const double slack = std::max(1.0, std::ceil(cells)) - cells;
    turned.offset[axis] = slack / 2 + growth.high - texels_per_unit * low[axis];
  }
  turned.mask =
      texelsOf(outline, placedVertices(outline, texels_per_unit, {angle_rad, turned.offset}), growth);
  turned.offset -= Vec2(turned.mask.left, turned.mask.bottom);
  turned.mask.left = turned.mask.bottom = 0;
  return turned;
}

}  // namespace bakelight::atlas
