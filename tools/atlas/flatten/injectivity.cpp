#include "tools/atlas/flatten/injectivity.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tools/atlas/charts/stretch.h"
#include "tools/atlas/exact.h"

namespace bakelight::atlas {
namespace {

struct Segment {
  Vec2 begin, end;
  BorderEdge edge;
  double low() const { return std::min(begin.x(), end.x()); }
  double high() const { return std::max(begin.x(), end.x()); }
};

bool boxesMeetInY(const Segment& a, const Segment& b) {
  const auto [a_low, a_high] = std::minmax(a.begin.y(), a.end.y());
  const auto [b_low, b_high] = std::minmax(b.begin.y(), b.end.y());
  return a_low <= b_high && b_low <= a_high;
}

}  // namespace

BadTriangles badTriangles(const Chart& chart, std::span<const Vec2> plane) {
  BadTriangles bad;
  for (const Triangle& t : chart.triangles) {
    const int turn = orientation(plane[t[0]], plane[t[1]], plane[t[2]]);
    bad.flipped += turn < 0;
    bad.collapsed += turn == 0;
  }
  return bad;
}

std::vector<BorderCrossing> borderCrossings(const Chart& chart, std::span<const Vec2> plane,
                                            std::size_t most) {
  std::vector<BorderCrossing> crossings;
  std::vector<Segment> segments;
  for (std::size_t l = 0; l < chart.borders.size(); ++l) {
    const auto& loop = chart.borders[l];
    for (std::size_t i = 0; i < loop.size(); ++i)
      segments.push_back({plane[loop[i]], plane[loop[(i + 1) % loop.size()]], {l, i}});
  }
  // Along x, each against those whose extents in x it meets; borders are thin enough for that to be few.
  std::sort(segments.begin(), segments.end(),
            [](const Segment& a, const Segment& b) { return a.low() < b.low(); });
  std::vector<const Segment*> open;
  for (const Segment& segment : segments) {
    std::erase_if(open, [&](const Segment* other) { return other->high() < segment.low(); });
    for (const Segment* other : open)
      if (boxesMeetInY(segment, *other) &&
          segmentsCross(segment.begin, segment.end, other->begin, other->end)) {
        crossings.push_back({segment.edge, other->edge});
        if (crossings.size() >= most) return crossings;
      }
    open.push_back(&segment);
  }
  return crossings;
}

bool bordersCross(const Chart& chart, std::span<const Vec2> plane) {
  return !borderCrossings(chart, plane, 1).empty();
}

bool bordersTurnRight(const Chart& chart, std::span<const Vec2> plane) {
  return std::count_if(chart.borders.begin(), chart.borders.end(), [&](const auto& loop) {
           // About its own first vertex, so that a small loop far from the origin keeps its sign.
           double twice_area = 0;
           for (std::size_t i = 1; i + 1 < loop.size(); ++i)
             twice_area += crossOf(plane[loop[0]], plane[loop[i]], plane[loop[i + 1]]);
           return twice_area > 0;
         }) == 1;
}

bool isInjective(const Chart& chart, std::span<const Vec2> plane) {
  return badTriangles(chart, plane).count() == 0 && bordersTurnRight(chart, plane) &&
         !bordersCross(chart, plane);
}

bool survivesRounding(const Chart& chart, std::span<const Vec2> plane) {
  constexpr double kCells = 1 << 20;
  std::vector<Vec2> rounded(plane.size());
  // What is narrow passes on every other grid.
  for (const double shift : {0.0, 0.25, 0.5, 0.75}) {
    for (const auto& loop : chart.borders)
      for (const std::uint32_t v : loop)
        rounded[v] = (plane[v] * kCells + Vec2(shift, 3 * shift)).array().round() / kCells;
    if (!bordersTurnRight(chart, rounded) || bordersCross(chart, rounded)) return false;
  }
  return true;
}

}  // namespace bakelight::atlas
