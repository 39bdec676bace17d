#include "tools/atlas/injectivity.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tools/atlas/exact.h"

namespace bakelight::atlas {
namespace {

struct Segment {
  Vec2 begin, end;
  double low() const { return std::min(begin.x(), end.x()); }
  double high() const { return std::max(begin.x(), end.x()); }
};

bool boxesMeetInY(const Segment& a, const Segment& b) {
  const auto [a_low, a_high] = std::minmax(a.begin.y(), a.end.y());
  const auto [b_low, b_high] = std::minmax(b.begin.y(), b.end.y());
  return a_low <= b_high && b_low <= a_high;
}

}  // namespace

std::int64_t flippedTriangles(const Chart& chart, std::span<const Vec2> plane) {
  return std::count_if(chart.triangles.begin(), chart.triangles.end(), [&](const Triangle& t) {
    return orientation(plane[t[0]], plane[t[1]], plane[t[2]]) <= 0;
  });
}

bool bordersCross(const Chart& chart, std::span<const Vec2> plane) {
  std::vector<Segment> segments;
  for (const auto& loop : chart.borders)
    for (std::size_t i = 0; i < loop.size(); ++i)
      segments.push_back({plane[loop[i]], plane[loop[(i + 1) % loop.size()]]});
  // Along x, each against those whose extents in x it meets; borders are thin enough for that to be few.
  std::sort(segments.begin(), segments.end(),
            [](const Segment& a, const Segment& b) { return a.low() < b.low(); });
  std::vector<const Segment*> open;
  for (const Segment& segment : segments) {
    std::erase_if(open, [&](const Segment* other) { return other->high() < segment.low(); });
    for (const Segment* other : open)
      if (boxesMeetInY(segment, *other) &&
          segmentsCross(segment.begin, segment.end, other->begin, other->end))
        return true;
    open.push_back(&segment);
  }
  return false;
}

bool isInjective(const Chart& chart, std::span<const Vec2> plane) {
  return flippedTriangles(chart, plane) == 0 && !bordersCross(chart, plane);
}

}  // namespace bakelight::atlas
